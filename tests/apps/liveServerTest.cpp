/** @file
 * Page of `recurse render --live` for clients of every kind.
 */
#include "program.h"

#include <arpa/inet.h>
#include <nlohmann/json.hpp>
#include <sys/socket.h>
#include <unistd.h>

#include "apps/view/filmViewers.h"

using namespace programTesting;

namespace {

/** Address that the program prints: http://HOST:PORT/PATH. */
struct PageAddress {
  std::string host, path;
  int port = 0;

  /** Empty if the messages have no address yet. */
  explicit PageAddress(const std::string& messages) {
    const size_t begin = messages.find("http://"), end = messages.find('\n', begin);
    if (begin == std::string::npos || end == std::string::npos) return;
    const std::string url = messages.substr(begin + 7, end - begin - 7);
    const size_t slash = url.find('/'), colon = url.rfind(':', slash);
    host = url.substr(0, colon);
    port = std::atoi(url.c_str() + colon + 1);
    path = url.substr(slash);
  }
  std::string authority() const { return host + ":" + std::to_string(port); }
};

/** A connection to a page. */
class PageClient {
 public:
  explicit PageClient(const PageAddress& page)
      : socket(::socket(page.host == "[::1]" ? AF_INET6 : AF_INET, SOCK_STREAM, 0)) {
    const timeval timeout{60, 0};
    ::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof timeout);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<uint16_t>(page.port));
    sockaddr_in6 address6{};
    address6.sin6_family = AF_INET6;
    address6.sin6_addr = in6addr_loopback;
    address6.sin6_port = address.sin_port;
    if (page.host == "[::1]")
      isOpen = ::connect(socket, reinterpret_cast<sockaddr*>(&address6), sizeof address6) == 0;
    else
      isOpen = ::connect(socket, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
  }
  PageClient(PageClient&& other) noexcept : socket(std::exchange(other.socket, -1)), isOpen(other.isOpen) {}
  ~PageClient() {
    if (socket >= 0) ::close(socket);
  }

  void send(const std::string& text) {
    isOpen = isOpen && ::send(socket, text.data(), text.size(), MSG_NOSIGNAL) == ssize_t(text.size());
  }
  /** All bytes until the connection is closed. */
  std::string answer() {
    std::string out, part(1 << 16, '\0');
    for (ssize_t size; isOpen && (size = ::recv(socket, part.data(), part.size(), 0)) > 0;)
      out.append(part, 0, size_t(size));
    return out;
  }

 private:
  int socket;
  bool isOpen = false;
};

/** Complete response to a request. */
std::string ask(const PageAddress& page, const std::string& method, const std::string& path,
                const std::string& host, const std::string& headers = {}) {
  PageClient client(page);
  client.send(method + " " + path + " HTTP/1.1\r\nHost: " + host + "\r\nConnection: close\r\n" + headers +
              "\r\n");
  return client.answer();
}

std::string ask(const PageAddress& page, const std::string& what, const std::string& headers = {}) {
  return ask(page, "GET", page.path + what, page.authority(), headers);
}

int statusOf(const std::string& answer) {
  return answer.starts_with("HTTP/1.1 ") ? std::atoi(answer.c_str() + 9) : 0;
}

/** Empty without a response. */
nlohmann::json stateOf(const PageAddress& page) {
  const std::string answer = ask(page, "state");
  const size_t body = answer.find("\r\n\r\n");
  return body == std::string::npos ? nlohmann::json::object()
                                   : nlohmann::json::parse(answer.substr(body + 4));
}

class LivePage : public Program {
 protected:
  /** Calls `visit` during a render without end, then interrupts the render. */
  Outcome live(const std::vector<std::string>& options,
               const std::function<void(const PageAddress&)>& visit) {
    std::vector<std::string> arguments = {"render",     "scene.pbrt", "--integrator", "path", "--spp",
                                          "1000000000", "-o",         "a.exr",        "-q",   "--live"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    return runAMinute(arguments, [&](pid_t child) {
      PageAddress page("");
      const bool isOpen = comesTo([&] {
        page = PageAddress(contents(file(".stderr")));
        return page.port != 0;
      });
      if (isOpen && comesTo([&] { return stateOf(page).value("version", 0) != 0; })) visit(page);
      ::kill(child, SIGINT);
    });
  }
};

} // namespace

TEST_F(LivePage, ARequestForManyRangesGetsOnePicture) {
  std::string ranges = "Range: bytes=0-", answer;
  for (int i = 0; i < 2000; ++i) ranges += ",0-";
  const Outcome o = live({}, [&](const PageAddress& page) {
    answer = ask(page, "shown?exposure=0&tonemap=none", ranges + "\r\n");
  });
  EXPECT_EQ(o.status, 130) << o.err;
  EXPECT_TRUE(exists("a.exr"));
  EXPECT_EQ(statusOf(answer), 200);
  EXPECT_GT(answer.size(), 24u * 16 * 3);
  EXPECT_LT(answer.size(), 24u * 16 * 3 + 2000);
}

TEST_F(LivePage, LongHeadersAreRefused) {
  std::string headers, answer;
  for (int i = 0; i < 20000; ++i) headers += "X-" + std::to_string(i) + ": a\r\n";
  live({}, [&](const PageAddress& page) { answer = ask(page, "state", headers); });
  EXPECT_NE(statusOf(answer), 200);
}

TEST_F(LivePage, SlowClientsKeepNobodyOutAndNoRenderFromEnding) {
  std::jthread drip;
  int status = 0;
  const Outcome o = live({}, [&](const PageAddress& page) {
    std::vector<PageClient> clients;
    for (int i = 0; i < 100; ++i) clients.emplace_back(page).send("GET / HTTP/1.1\r\n");
    drip = std::jthread([clients = std::move(clients)](const std::stop_token& ended) mutable {
      for (; !ended.stop_requested(); sleepSeconds(0.2))
        for (PageClient& client : clients) client.send("X: a\r\n");
    });
    status = statusOf(ask(page, "state"));
  });
  EXPECT_EQ(status, 200);
  EXPECT_EQ(o.status, 130) << o.err; // SIGKILL if clients delay the end by a minute
  EXPECT_TRUE(exists("a.exr"));
}

TEST_F(LivePage, OnlyWhoHasThePrintedAddressMayWatchAndStop) {
  bool wasStopped = true, isStopped = false;
  const Outcome o = live({}, [&](const PageAddress& page) {
    EXPECT_GT(page.path.size(), 20u);
    for (const char* path : {"/", "/state", "/shown", "/pixel?x=1&y=1", "/0/state", "//state"})
      EXPECT_EQ(statusOf(ask(page, "GET", path, page.authority())), 403) << path;
    const std::string stop = page.path + "stop";
    EXPECT_EQ(statusOf(ask(page, "POST", "/stop", page.authority())), 403);
    EXPECT_EQ(statusOf(ask(page, "POST", stop, "rebound.example:" + std::to_string(page.port))), 403);
    EXPECT_EQ(statusOf(ask(page, "POST", stop, page.authority(), "Origin: http://other.example\r\n")), 403);
    EXPECT_EQ(statusOf(ask(page, "GET", stop, page.authority())), 404);
    wasStopped = stateOf(page).value("stopped", true);
    EXPECT_EQ(
        statusOf(ask(page, "POST", stop, page.authority(), "Origin: http://" + page.authority() + "\r\n")),
        204);
    isStopped = appears("a.exr");
  });
  EXPECT_FALSE(wasStopped);
  EXPECT_TRUE(isStopped);
  EXPECT_EQ(o.status, 130) << o.err;
}

TEST_F(LivePage, HasTheGuideAndTheTimeThatLearningTakes) {
  nlohmann::json state;
  live({"--set", "guided=true"}, [&](const PageAddress& page) {
    comesTo([&] { return !(state = stateOf(page))["guide"].is_null(); });
  });
  EXPECT_GT(state["guide"]["cells"], 0);
  EXPECT_GT(state["guide"]["records"], 0);
  EXPECT_LE(state["guide"]["fraction_on"], 1);
  EXPECT_GT(state["learning_seconds"], 0);
}

TEST_F(LivePage, NamesOfTheMachineAreAllowedByOption) {
  const Outcome o = live({"--live-host", "studio.example"}, [&](const PageAddress& page) {
    for (const char* host : {"studio.example:80", "STUDIO.example", "localhost:9000", "127.0.0.1", "[::1]:1"})
      EXPECT_EQ(statusOf(ask(page, "GET", page.path + "state", host)), 200) << host;
    for (const char* host : {"other.example", "studio.example.other", "", "127.0.0.1.example"})
      EXPECT_EQ(statusOf(ask(page, "GET", page.path + "state", host)), 403) << host;
  });
  EXPECT_EQ(o.status, 130) << o.err;
}

TEST_F(LivePage, MayNotStandInAFrame) {
  std::string answer;
  live({}, [&](const PageAddress& page) { answer = ask(page, ""); });
  const std::string headers = answer.substr(0, answer.find("\r\n\r\n"));
  EXPECT_EQ(statusOf(answer), 200);
  EXPECT_TRUE(has(headers, "Content-Security-Policy: ") && has(headers, "frame-ancestors 'none'")) << headers;
  EXPECT_TRUE(has(headers, "Referrer-Policy: same-origin")) << headers;
}

TEST_F(LivePage, WhoWatchesGetsTheLastPicture) {
  using namespace recurse::apps;
  ViewerOptions options;
  options.live = true;
  options.patience = 60;
  testing::internal::CaptureStderr();
  std::optional<FilmViewers> viewers(std::in_place, options, DevelopOptions(), "picture", [] {});
  const PageAddress page(testing::internal::GetCapturedStderr());
  const recurse::Image picture(24, 16, {"R", "G", "B"});
  viewers->look([&] { return picture; }, [](const std::string&) {});

  const int64_t before = stateOf(page).value("version", 0); // from now on the page is open
  EXPECT_GT(before, 0);
  int64_t last = 0, shown = -1;
  std::thread watcher([&] {
    EXPECT_TRUE(comesTo([&] { return stateOf(page).value("finished", false); }));
    last = stateOf(page).value("version", 0);
    const std::string answer = ask(page, "shown?exposure=0&tonemap=none"), header = "Picture-Version: ";
    if (const size_t at = answer.find(header); at != std::string::npos)
      shown = std::atoll(answer.c_str() + at + header.size());
  });
  viewers->finish(picture, [](const std::string&) {});
  viewers.reset();
  watcher.join();
  EXPECT_GT(last, before);
  EXPECT_EQ(shown, last);
}

TEST_F(LivePage, IsServedAtAddressesOfIpv6) {
  const int probe = ::socket(AF_INET6, SOCK_STREAM, 0);
  sockaddr_in6 loopback{};
  loopback.sin6_family = AF_INET6;
  loopback.sin6_addr = in6addr_loopback;
  const bool hasIpv6 = ::bind(probe, reinterpret_cast<sockaddr*>(&loopback), sizeof loopback) == 0;
  ::close(probe);
  if (!hasIpv6) GTEST_SKIP() << "this machine has no IPv6";
  for (const char* address : {"[::1]", "[::1]:0"}) {
    int status = 0;
    const Outcome o = live({"--live-address", address}, [&](const PageAddress& page) {
      EXPECT_EQ(page.host, "[::1]");
      status = statusOf(ask(page, "state"));
    });
    EXPECT_EQ(status, 200) << address;
    EXPECT_EQ(o.status, 130) << o.err;
  }
}
