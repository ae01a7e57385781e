/** @file
 * `recurse render --display-server`: faulty viewers.
 */
#include "program.h"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include "apps/view/tevClient.h"
#include "recurse/core/image/image.h"
#include "recurse/core/io/error.h"

using namespace programTesting;

using recurse::apps::TevClient;

namespace {

class DisplayServer : public Program {};

/** Viewer that accepts connections, and never reads from them. */
class DeafViewer {
 public:
  DeafViewer() : listener(::socket(AF_INET, SOCK_STREAM, 0)) {
    const int bytes = 4096;
    ::setsockopt(listener, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
    sockaddr_in bound{};
    bound.sin_family = AF_INET;
    bound.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof bound;
    EXPECT_EQ(::bind(listener, reinterpret_cast<sockaddr*>(&bound), size), 0);
    EXPECT_EQ(::getsockname(listener, reinterpret_cast<sockaddr*>(&bound), &size), 0);
    EXPECT_EQ(::listen(listener, 4), 0);
    port = ntohs(bound.sin_port);
  }
  ~DeafViewer() { ::close(listener); }
  DeafViewer(const DeafViewer&) = delete;
  DeafViewer& operator=(const DeafViewer&) = delete;
  std::string address() const { return "127.0.0.1:" + std::to_string(port); }

 private:
  int listener, port = 0;
};

} // namespace

TEST_F(DisplayServer, ARenderGoesOnWithoutAViewerThatDoesNotRead) {
  const DeafViewer viewer;
  const Outcome o = run({"render", "scene.pbrt", "--integrator", "path", "--spp", "1", "-q", "-o", "a.exr",
                         "--resolution", "800x700", "--display-server", viewer.address()});
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_TRUE(has(o.err, "the render continues without it")) << o.err;
}

TEST_F(DisplayServer, NothingIsSentAfterTheDeadline) {
  const DeafViewer viewer;
  // Each of a hundred pictures would wait for the timeout of three seconds.
  constexpr int PICTURES = 100;
  TevClient client(viewer.address(), "picture");
  client.endBy(TevClient::Clock::now());
  recurse::Image picture(800, 700, {"R", "G", "B"});
  const auto start = TevClient::Clock::now();
  for (int i = 0; i < PICTURES; ++i) EXPECT_THROW(client.send(picture), recurse::Error);
  EXPECT_LT(TevClient::Clock::now() - start, std::chrono::seconds(PICTURES));
}

TEST_F(DisplayServer, AddressesOfIpv6AreUnderstood) {
  const Outcome o = run({"render", "scene.pbrt", "--integrator", "path", "--spp", "1", "-q", "-o", "a.exr",
                         "--display-server", "[::1]:1"});
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_TRUE(has(o.err, "[::1]:1: ")) << o.err;
  EXPECT_FALSE(has(o.err, "not known")) << o.err;
  for (const char* wrong : {"::1:14158", "[::1]", "[::1]14158", "[::1:14158", "host", ":1", "host:x"})
    EXPECT_EQ(run({"render", "scene.pbrt", "-o", "a.exr", "--display-server", wrong}).status, 2) << wrong;
}
