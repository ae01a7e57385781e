/** @file
 * The server of the live page (cpp-httplib): the page, the state as JSON, the picture developed as the page
 * asks.
 */
#include "apps/liveServer.h"

#include <chrono>
#include <cmath>
#include <mutex>
#include <thread>

#include <httplib.h>
#include <nlohmann/json.hpp>

#include "apps/developOptions.h"
#include "apps/optionText.h"
#include "recurse/core/error.h"
#include "recurse/model/plugIns.h"
#include "report/htmlPage.h"
#include "report/page/embedded.h"

namespace recurse::apps {

namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

double ageOf(Clock::time_point time) { return std::chrono::duration<double>(Clock::now() - time).count(); }

/** "HOST", "HOST:PORT", ":PORT": host and port, 0 for any. */
std::pair<std::string, int> parseAddress(const std::string& address) {
  const size_t colon = address.rfind(':');
  const std::string host = address.substr(0, colon);
  int port = 0;
  if (colon != std::string::npos)
    port = static_cast<int>(parseCount("--live-address", address.substr(colon + 1), 0, 65535));
  return {host.empty() ? LOOPBACK : host, port};
}

Json numberOrNull(double value) { return std::isfinite(value) && value >= 0 ? Json(value) : Json(nullptr); }

std::string pageText(const std::string& title) {
  const Json data = {{"title", title}, {"operators", plugIns().toneMaps.names()}};
  return htmlPage({page::LIVE_HTML,
                   title + " · live",
                   {page::PAGE_CSS, page::STILLS_CSS, page::LIVE_CSS},
                   {},
                   {page::PIXELS_JS, page::VIEW_JS, page::LIVE_JS}},
                  data);
}

} // namespace

struct LiveServer::Parts {
  httplib::Server server;
  std::thread thread;
  std::string url, page;
  std::function<void()> stop;

  std::mutex mutex; ///< of what follows
  std::shared_ptr<const Image> picture;
  uint64_t version = 0, fetched = 0; ///< of the picture: newest, and the last one that was asked for
  RenderProgress progress;
  bool finished = false, stopped = false;
  double developSeconds = 0;
  Clock::time_point lastVisit{};

  std::shared_ptr<const Image> newest() {
    const std::lock_guard<std::mutex> guard(mutex);
    return picture;
  }
  void addRoutes();
  std::string stateJson();
  void answerShown(const httplib::Request& request, httplib::Response& response);
  void answerPixel(const httplib::Request& request, httplib::Response& response);
};

std::string LiveServer::Parts::stateJson() {
  const std::lock_guard<std::mutex> guard(mutex);
  lastVisit = Clock::now();
  const Json state = {{"version", version},
                      {"width", picture ? picture->width : 0},
                      {"height", picture ? picture->height : 0},
                      {"phase", progress.phase},
                      {"fraction", progress.fraction},
                      {"elapsed", progress.elapsed},
                      {"seconds_left", numberOrNull(progress.secondsLeft)},
                      {"samples_per_pixel", progress.samplesPerPixel},
                      {"rays_per_second", progress.raysPerSecond},
                      {"error", numberOrNull(progress.error)},
                      {"stopped", stopped},
                      {"finished", finished}};
  return state.dump();
}

/** The newest picture as bytes, red, green, blue, row by row: `exposure` and `tonemap` as the options. */
void LiveServer::Parts::answerShown(const httplib::Request& request, httplib::Response& response) {
  uint64_t shown = 0;
  std::shared_ptr<const Image> image;
  {
    const std::lock_guard<std::mutex> guard(mutex);
    image = picture;
    shown = version;
  }
  if (!image) return void(response.status = 404);
  DevelopOptions options;
  if (request.has_param("exposure")) options.exposure = request.get_param_value("exposure");
  if (request.has_param("tonemap")) options.toneMap = request.get_param_value("tonemap");
  const Clock::time_point start = Clock::now();
  const Developed developed = develop(*image, options.settings());
  std::string bytes(developed.picture.pixels.size(), '\0');
  for (size_t i = 0; i < bytes.size(); ++i)
    bytes[i] = static_cast<char>(std::lround(255 * developed.picture.pixels[i]));
  response.set_header("Picture-Size", std::to_string(image->width) + "x" + std::to_string(image->height));
  response.set_header("Picture-Version", std::to_string(shown));
  response.set_header("Picture-Stops", formatted("%.3f", developed.stops));
  response.set_content(bytes, "application/octet-stream");
  const std::lock_guard<std::mutex> guard(mutex);
  developSeconds = ageOf(start);
  fetched = std::max(fetched, shown);
}

/** The linear values of the pixel `x`, `y`. */
void LiveServer::Parts::answerPixel(const httplib::Request& request, httplib::Response& response) {
  const std::shared_ptr<const Image> image = newest();
  if (!image) return void(response.status = 404);
  const int64_t x = parseCount("x", request.get_param_value("x"), 0, image->width - 1);
  const int64_t y = parseCount("y", request.get_param_value("y"), 0, image->height - 1);
  const Rgb c = image->rgb(int(x), int(y));
  const auto value = [](float v) { return std::isfinite(v) ? Json(v) : Json(nullptr); };
  response.set_content(Json::array({value(c.r), value(c.g), value(c.b)}).dump(), "application/json");
}

void LiveServer::Parts::addRoutes() {
  const auto get = [this](const char* path, const auto& answer) {
    server.Get(path, [answer](const httplib::Request& request, httplib::Response& response) {
      response.set_header("Cache-Control", "no-store");
      try {
        answer(request, response);
      } catch (const Error& error) {
        response.status = 400;
        response.set_content(error.what(), "text/plain; charset=utf-8");
      }
    });
  };
  get("/", [this](const auto&, auto& response) { response.set_content(page, "text/html; charset=utf-8"); });
  get("/state",
      [this](const auto&, auto& response) { response.set_content(stateJson(), "application/json"); });
  get("/shown", [this](const auto& request, auto& response) { answerShown(request, response); });
  get("/pixel", [this](const auto& request, auto& response) { answerPixel(request, response); });
  server.Post("/stop", [this](const httplib::Request& request, httplib::Response& response) {
    // A page from elsewhere must not stop the render.
    const std::string origin = request.get_header_value("Origin");
    if (!origin.empty() && origin != "http://" + request.get_header_value("Host")) {
      response.status = 403;
      return;
    }
    response.status = 204;
    {
      const std::lock_guard<std::mutex> guard(mutex);
      stopped = true;
    }
    stop();
  });
}

LiveServer::LiveServer(const std::string& address, const std::string& title, std::function<void()> stop)
    : parts(std::make_unique<Parts>()) {
  parts->stop = std::move(stop);
  parts->page = pageText(title);
  parts->addRoutes();
  parts->server.new_task_queue = [] { return new httplib::ThreadPool(4); };
  parts->server.set_keep_alive_timeout(1);
  // The library would share a port that another program has.
  parts->server.set_socket_options([](int socket) {
    const int yes = 1;
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  const auto [host, wanted] = parseAddress(address);
  int port = wanted;
  if (wanted == 0)
    port = parts->server.bind_to_any_port(host);
  else if (!parts->server.bind_to_port(host, wanted))
    port = -1;
  if (port <= 0)
    throw Error("--live: cannot listen at " + host + (wanted ? ":" + std::to_string(wanted) : "") +
                "; the port is in use, or the address is not one of this machine");
  parts->url = "http://" + host + ":" + std::to_string(port) + "/";
  parts->thread = std::thread([this] { parts->server.listen_after_bind(); });
  while (!parts->server.is_running()) std::this_thread::yield();
}

LiveServer::~LiveServer() {
  parts->server.stop();
  parts->thread.join();
}

const std::string& LiveServer::url() const { return parts->url; }

double LiveServer::cost() const {
  const std::lock_guard<std::mutex> guard(parts->mutex);
  return parts->developSeconds;
}

void LiveServer::show(Image picture) {
  auto newest = std::make_shared<const Image>(std::move(picture));
  const std::lock_guard<std::mutex> guard(parts->mutex);
  parts->picture = std::move(newest);
  ++parts->version;
}

void LiveServer::show(const RenderProgress& progress) {
  const std::lock_guard<std::mutex> guard(parts->mutex);
  parts->progress = progress;
}

void LiveServer::finish() {
  constexpr double PATIENCE = 2; // seconds for a page that is open to fetch the last picture
  const Clock::time_point start = Clock::now();
  const auto awaited = [this] {
    const std::lock_guard<std::mutex> guard(parts->mutex);
    parts->finished = true;
    return ageOf(parts->lastVisit) < PATIENCE && parts->fetched < parts->version;
  };
  while (awaited() && ageOf(start) < PATIENCE) std::this_thread::sleep_for(std::chrono::milliseconds(50));
}

} // namespace recurse::apps
