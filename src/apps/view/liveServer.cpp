/** @file
 * Live page: the page itself, the state as JSON, and the picture developed as the page requests. Anyone with
 * the printed address may watch and stop the render. The address contains a random token, which no other user
 * of the machine and no other page in the browser knows.
 */
#include "apps/view/liveServer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <mutex>
#include <thread>

#include <nlohmann/json.hpp>
#include <sys/random.h>

#include "apps/options/developOptions.h"
#include "apps/options/optionText.h"
#include "apps/view/httpServer.h"
#include "recurse/core/io/error.h"
#include "recurse/core/io/text.h"
#include "recurse/model/scene/plugIns.h"
#include "report/page/embedded.h"
#include "report/page/htmlPage.h"

namespace recurse::apps {

namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

double ageOf(Clock::time_point time) { return std::chrono::duration<double>(Clock::now() - time).count(); }

/** 128 random bits as text. */
std::string randomToken() {
  std::array<unsigned char, 16> bytes;
  if (::getrandom(bytes.data(), bytes.size(), 0) != ssize_t(bytes.size()))
    throw Error("--live: the system provides no random numbers for the address");
  std::string out;
  for (const unsigned char byte : bytes) out += formatted("%02x", unsigned(byte));
  return out;
}

/** Comparison in constant time: its duration does not depend on where the texts differ. */
bool beginsWith(const std::string& text, const std::string& secret) {
  unsigned difference = text.size() < secret.size();
  for (size_t i = 0; i < secret.size() && i < text.size(); ++i)
    difference |= static_cast<unsigned char>(text[i]) ^ static_cast<unsigned char>(secret[i]);
  return difference == 0;
}

/** The host of a Host header in lower case, without its port. */
std::string hostOf(const std::string& given) {
  const std::string header = lowerCase(given);
  const size_t bracket = header.starts_with('[') ? header.find(']') : 0;
  return bracket == std::string::npos ? "" : header.substr(0, header.find(':', bracket));
}

HttpAnswer refusal(int status, const std::string& why) {
  HttpAnswer out;
  out.status = status;
  out.body = why + "\n";
  return out;
}

HttpAnswer json(const std::string& text) {
  HttpAnswer out;
  out.type = "application/json";
  out.body = text;
  return out;
}

Json numberOrNull(double value) { return std::isfinite(value) && value >= 0 ? Json(value) : Json(nullptr); }

/** Vector of three numbers between commas. */
Vec3f vectorParameter(const HttpRequest& request, const std::string& name) {
  const auto given = request.parameters.find(name);
  const std::vector<std::string> numbers =
      given == request.parameters.end() ? std::vector<std::string>() : split(given->second, ',');
  if (numbers.size() != 3) badUsage(name + ": needs three numbers");
  Vec3f out;
  for (int k = 0; k < 3; ++k) out[k] = static_cast<float>(parseReal(name, numbers[size_t(k)]));
  return out;
}

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
  std::unique_ptr<HttpServer> server;
  std::string url, root, page; ///< root: the path that all of the page's addresses begin with
  std::vector<std::string> hosts;
  std::function<void()> stop;

  std::mutex mutex; ///< guards the members below
  std::shared_ptr<const Image> picture;
  std::shared_ptr<PixelQueries> queries; ///< null: none are answered
  uint64_t version = 0, fetched = 0;     ///< of pictures: newest, and latest one fetched
  RenderProgress progress;
  bool finished = false, stopped = false;
  double developSeconds = 0;
  Clock::time_point lastVisit{};

  std::shared_ptr<const Image> newest() {
    const std::lock_guard<std::mutex> guard(mutex);
    return picture;
  }
  /** What answers questions about pixels. Throws Error if nobody does. */
  std::shared_ptr<PixelQueries> answering() {
    const std::lock_guard<std::mutex> guard(mutex);
    if (!queries) throw Error("The render answers no questions about pixels now.");
    return queries;
  }
  HttpAnswer paths();
  HttpAnswer reference(const HttpRequest& request);
  HttpAnswer ask(const HttpRequest& request);
  HttpAnswer answer(const HttpRequest& request);
  HttpAnswer answerGet(const std::string& what, const HttpRequest& request);
  HttpAnswer answerPost(const std::string& what, const HttpRequest& request);
  bool isAllowed(const std::string& host, const HttpRequest& request) const;
  std::string stateJson();
  HttpAnswer shownPicture(const HttpRequest& request);
  HttpAnswer pixel(const HttpRequest& request);
};

std::string LiveServer::Parts::stateJson() {
  const std::lock_guard<std::mutex> guard(mutex);
  lastVisit = Clock::now();
  const PixelQuestion question = queries ? queries->question() : PixelQuestion();
  const Json guide = progress.guide ? Json{{"cells", progress.guide->cells},
                                           {"fraction_on", progress.guide->fractionOn()},
                                           {"records", progress.guide->records}}
                                    : Json();
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
                      {"learning_seconds", progress.learningSeconds},
                      {"guide", guide},
                      {"stopped", stopped},
                      {"finished", finished},
                      {"answers_pixels", queries != nullptr},
                      {"question", question.number},
                      {"answered", question.isAnswered}};
  return state.dump();
}

/** Newest picture as bytes R, G, B, row by row; the parameters `exposure` and `tonemap` are the options. */
HttpAnswer LiveServer::Parts::shownPicture(const HttpRequest& request) {
  uint64_t shown = 0;
  std::shared_ptr<const Image> image;
  {
    const std::lock_guard<std::mutex> guard(mutex);
    image = picture;
    shown = version;
  }
  if (!image) return refusal(404, "The picture has no samples yet.");
  DevelopOptions options;
  const auto set = [&](const char* name, std::string& option) {
    if (const auto given = request.parameters.find(name); given != request.parameters.end())
      option = given->second;
  };
  set("exposure", options.exposure);
  set("tonemap", options.toneMap);
  const Clock::time_point start = Clock::now();
  const Developed developed = develop(*image, options.settings());
  HttpAnswer out;
  out.type = "application/octet-stream";
  out.body.resize(developed.picture.pixels.size());
  for (size_t i = 0; i < out.body.size(); ++i)
    out.body[i] = static_cast<char>(std::lround(255 * developed.picture.pixels[i]));
  out.headers = {{"Picture-Size", std::to_string(image->width) + "x" + std::to_string(image->height)},
                 {"Picture-Version", std::to_string(shown)},
                 {"Picture-Stops", formatted("%.3f", developed.stops)}};
  const std::lock_guard<std::mutex> guard(mutex);
  developSeconds = ageOf(start);
  fetched = std::max(fetched, shown);
  return out;
}

/** Linear values of the pixel `x`, `y`. */
HttpAnswer LiveServer::Parts::pixel(const HttpRequest& request) {
  const std::shared_ptr<const Image> image = newest();
  if (!image) return refusal(404, "The picture has no samples yet.");
  const auto coordinate = [&](const char* name, int size) {
    const auto given = request.parameters.find(name);
    return int(parseCount(name, given == request.parameters.end() ? "" : given->second, 0, size - 1));
  };
  const Rgb c = image->rgb(coordinate("x", image->width), coordinate("y", image->height));
  const auto value = [](float v) { return std::isfinite(v) ? Json(v) : Json(nullptr); };
  return json(Json::array({value(c.r), value(c.g), value(c.b)}).dump());
}

/** Page with the paths of the pixel of the latest answer. */
HttpAnswer LiveServer::Parts::paths() {
  HttpAnswer out;
  out.type = "text/html; charset=utf-8";
  const std::shared_ptr<const Image> image = newest();
  if (image) out.body = answering()->page(*image);
  return out.body.empty() ? refusal(404, "No pixel has been answered yet.") : out;
}

/** Path tracing at the surface point `position` with the normal `normal`. */
HttpAnswer LiveServer::Parts::reference(const HttpRequest& request) {
  return json(
      answering()->reference(vectorParameter(request, "position"), vectorParameter(request, "normal")));
}

/** Requests the paths of the pixel (`x`, `y`); the state reports when the answer is ready. */
HttpAnswer LiveServer::Parts::ask(const HttpRequest& request) {
  const auto coordinate = [&](const char* name) {
    const auto given = request.parameters.find(name);
    return int(parseCount(name, given == request.parameters.end() ? "" : given->second, 0, 1 << 30));
  };
  const std::shared_ptr<PixelQueries> queries = answering();
  queries->ask(coordinate("x"), coordinate("y"));
  return json(Json{{"question", queries->question().number}}.dump());
}

HttpAnswer LiveServer::Parts::answerGet(const std::string& what, const HttpRequest& request) {
  if (what == "state") return json(stateJson());
  if (what == "shown") return shownPicture(request);
  if (what == "pixel") return pixel(request);
  if (what == "paths") return paths();
  if (what == "reference") return reference(request);
  if (!what.empty()) return refusal(404, "There is no such page.");
  HttpAnswer out;
  out.type = "text/html; charset=utf-8";
  out.body = page;
  return out;
}

HttpAnswer LiveServer::Parts::answerPost(const std::string& what, const HttpRequest& request) {
  const std::string origin = request.header("origin");
  if (!origin.empty() && origin != "http://" + request.header("host"))
    return refusal(403, "Only the page itself may do this.");
  if (what == "ask") return ask(request);
  if (what != "stop") return refusal(404, "There is no such page.");
  {
    const std::lock_guard<std::mutex> guard(mutex);
    stopped = true;
  }
  stop();
  HttpAnswer out;
  out.status = 204;
  out.type.clear();
  return out;
}

/** True for known names of this machine: a name server could make any name lead here (DNS rebinding). */
bool LiveServer::Parts::isAllowed(const std::string& host, const HttpRequest& request) const {
  return host == request.localHost || std::find(hosts.begin(), hosts.end(), host) != hosts.end();
}

HttpAnswer LiveServer::Parts::answer(const HttpRequest& request) {
  const std::string host = hostOf(request.header("host"));
  if (!isAllowed(host, request))
    return refusal(403, "The page is not available under the host name '" + host +
                            "'; --live-host allows another name.");
  if (!beginsWith(request.path, root))
    return refusal(403, "Open the whole address that the program has printed.");
  const std::string what = request.path.substr(root.size());
  if (request.method == "GET") return answerGet(what, request);
  if (request.method == "POST") return answerPost(what, request);
  return refusal(400, "Requests are GET or POST.");
}

LiveServer::LiveServer(const std::string& address, const std::vector<std::string>& hosts,
                       const std::string& title, std::function<void()> stop)
    : parts(std::make_unique<Parts>()) {
  NetworkAddress place = parseNetworkAddress("--live-address", address, "127.0.0.1:8080");
  if (place.host.empty()) place.host = LOOPBACK;
  parts->stop = std::move(stop);
  parts->page = pageText(title);
  parts->root = "/" + randomToken() + "/";
  parts->hosts = {"localhost", "127.0.0.1", "[::1]", place.hostText()};
  parts->hosts.insert(parts->hosts.end(), hosts.begin(), hosts.end());
  for (std::string& host : parts->hosts) host = hostOf(host);
  const auto answer = [this](const HttpRequest& request) {
    HttpAnswer out;
    try {
      out = parts->answer(request);
    } catch (const Error& error) {
      out = refusal(400, error.what());
    } catch (const std::exception& error) { // e.g. std::bad_alloc: the request fails, the render continues
      out = refusal(500, error.what());
    }
    // The page shows that of a pixel in a frame; nobody else may show either of them.
    const std::string ancestors = request.path == parts->root + "paths" ? "'self'" : "'none'";
    out.headers.insert(
        out.headers.end(),
        {{"Cache-Control", "no-store"},
         {"Referrer-Policy", "same-origin"},
         {"X-Content-Type-Options", "nosniff"},
         {"Content-Security-Policy",
          "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:; "
          "connect-src 'self'; frame-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors " +
              ancestors}});
    return out;
  };
  try {
    parts->server = std::make_unique<HttpServer>(place, answer);
  } catch (const Error& error) {
    throw Error(std::string("--live: ") + error.what());
  }
  place.port = parts->server->port();
  parts->url = "http://" + place.text() + parts->root;
}

// The server's thread ends before the members that it uses.
LiveServer::~LiveServer() {
  setQueries(nullptr);
  parts->server.reset();
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

void LiveServer::setQueries(std::shared_ptr<PixelQueries> queries) {
  const std::lock_guard<std::mutex> guard(parts->mutex);
  if (parts->queries && parts->queries != queries) parts->queries->stop();
  parts->queries = std::move(queries);
}

void LiveServer::begin() {
  const std::lock_guard<std::mutex> guard(parts->mutex);
  parts->stopped = parts->finished = false;
}

void LiveServer::finish(double patience) {
  const Clock::time_point start = Clock::now();
  const auto awaited = [&] {
    const std::lock_guard<std::mutex> guard(parts->mutex);
    parts->finished = true;
    return ageOf(parts->lastVisit) < patience &&
           (parts->fetched < parts->version || parts->server->isAnswering());
  };
  while (awaited() && ageOf(start) < patience) std::this_thread::sleep_for(std::chrono::milliseconds(50));
}

} // namespace recurse::apps
