/** @file
 * `recurse render --display-server`: viewers that do not do their part.
 */
#include "program.h"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

using namespace programTesting;

namespace {

class DisplayServer : public Program {
 protected:
  Outcome render(const std::string& server) const {
    std::vector<std::string> arguments = {"render", "scene.pbrt", "--integrator", "path",  "--spp",
                                          "1",      "-q",         "-o",           "a.exr", "--resolution",
                                          "800x700"};
    if (!server.empty()) arguments.insert(arguments.end(), {"--display-server", server});
    return run(arguments);
  }
};

} // namespace

TEST_F(DisplayServer, AViewerThatDoesNotReadHardlyDelaysTheEnd) {
  const int viewer = ::socket(AF_INET, SOCK_STREAM, 0);
  const int bytes = 4096;
  ::setsockopt(viewer, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  ASSERT_EQ(::bind(viewer, reinterpret_cast<sockaddr*>(&address), size), 0);
  ASSERT_EQ(::getsockname(viewer, reinterpret_cast<sockaddr*>(&address), &size), 0);
  ASSERT_EQ(::listen(viewer, 4), 0);
  const double alone = render("").seconds;
  const Outcome o = render("127.0.0.1:" + std::to_string(ntohs(address.sin_port)));
  ::close(viewer);
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_TRUE(has(o.err, "the render goes on without it")) << o.err;
  EXPECT_LT(o.seconds - alone, 5);
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
