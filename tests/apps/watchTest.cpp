/** @file
 * `recurse render --watch`: a change of a file of the scene starts a new render.
 */
#include "program.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "recurse/core/image/image.h"

using namespace programTesting;
using recurse::readImage;

namespace {

class Watch : public Program {
 protected:
  /** Waits until the output contains the words for the `count`th time. */
  bool said(const std::string& words, size_t count) const {
    return comesTo([&] {
      const std::string text = contents(file(".stderr"));
      size_t found = 0;
      for (size_t at = text.find(words); at != std::string::npos; at = text.find(words, at + 1)) ++found;
      return found >= count;
    });
  }
  /** Processor time of all threads [s]. */
  static double processorSeconds(pid_t process) {
    std::istringstream stat(contents("/proc/" + std::to_string(process) + "/stat"));
    std::string word;
    for (int i = 1; i < 14; ++i) stat >> word; // utime and stime are fields 14 and 15
    double user = 0, system = 0;
    stat >> user >> system;
    return (user + system) / double(::sysconf(_SC_CLK_TCK));
  }
  static constexpr const char* WAITING = "waiting for changes";
};

/** The live page of a program under way. */
class LivePage {
 public:
  /** `said`: output of the program up to now. */
  explicit LivePage(const std::string& said) {
    const std::string scheme = "http://";
    const size_t at = said.find(scheme);
    if (at == std::string::npos) return;
    const std::string url =
        said.substr(at + scheme.size(), said.find_first_of(" \n", at) - at - scheme.size());
    host = url.substr(0, url.find('/'));
    base = url.substr(url.find('/'));
  }
  /** Response with its header; empty without a response. */
  std::string answer(const std::string& method, const std::string& path) const {
    const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<uint16_t>(std::atoi(host.c_str() + host.find(':') + 1)));
    std::string out;
    if (::connect(socket, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0) {
      const std::string request = method + " " + base + path + " HTTP/1.1\r\nHost: " + host +
                                  "\r\nConnection: close\r\nContent-Length: 0\r\n\r\n";
      ::send(socket, request.data(), request.size(), MSG_NOSIGNAL);
      char bytes[4096];
      for (ssize_t n; (n = ::recv(socket, bytes, sizeof bytes, 0)) > 0;) out.append(bytes, size_t(n));
    }
    ::close(socket);
    return out;
  }
  /** Number from the state of the page; -1 without a response. */
  double state(const std::string& name) const {
    const std::string text = answer("GET", "state"), key = "\"" + name + "\":";
    const size_t at = text.find(key);
    return at == std::string::npos ? -1 : std::atof(text.c_str() + at + key.size());
  }

 private:
  std::string host, base;
};

} // namespace

TEST_F(Watch, RendersAgainAfterChangesAndErrors) {
  write("more.pbrt", "Material \"diffuse\"\n");
  const std::string with = scene("", "Include \"more.pbrt\"\nShape \"sphere\" \"float radius\" .2\n");
  write("scene.pbrt", with);
  const Outcome o =
      run({"render", "scene.pbrt", "--watch", "-o", "w.exr", "--integrator", "path"}, [&](pid_t child) {
        EXPECT_TRUE(said(WAITING, 1));
        EXPECT_EQ(readImage(file("w.exr")).width, 24);
        const std::vector<float> before = readImage(file("w.exr")).pixels;
        write("more.pbrt", "Material \"diffuse\" \"rgb reflectance\" [ 0 .9 0 ]\n"); // an included file
        EXPECT_TRUE(said(WAITING, 2));
        EXPECT_FALSE(readImage(file("w.exr")).pixels == before);
        write("scene.pbrt", with + "Shape \"nonsense\"\n");
        EXPECT_TRUE(said("unknown Shape", 1) && said(WAITING, 3));
        write("scene.pbrt", with);
        EXPECT_TRUE(said(WAITING, 4));
        ::kill(child, SIGINT);
      });
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_TRUE(has(o.err, "\n6x4 pixels") || o.err.starts_with("6x4 pixels")) << o.err;
  EXPECT_TRUE(has(o.err, "\n24x16 pixels")) << o.err;
  EXPECT_EQ(leftBehind(), 0u);
}

TEST_F(Watch, EndsARenderThatIsUnderWay) {
  const Outcome o = run({"render", "scene.pbrt", "--watch", "-o", "w.exr", "--integrator", "path", "--spp",
                         "100000000", "--progress", "json"},
                        [&](pid_t child) {
                          EXPECT_TRUE(isUnderWay());
                          write("scene.pbrt", scene() + "Shape \"nonsense\"\n");
                          EXPECT_TRUE(said("unknown Shape", 1));
                          ::kill(child, SIGINT);
                        });
  EXPECT_EQ(o.status, 0) << o.err;
}

TEST_F(Watch, ShowsAllRendersOnOneLivePage) {
  const Outcome o = run({"render", "scene.pbrt", "--watch", "--live", "-o", "w.exr", "--integrator", "path"},
                        [&](pid_t child) {
                          EXPECT_TRUE(said(WAITING, 1));
                          const LivePage page(contents(file(".stderr")));
                          const double before = page.state("version");
                          EXPECT_GT(before, 0);
                          EXPECT_EQ(page.state("width"), 24);
                          write("scene.pbrt", scene("", "Shape \"sphere\" \"float radius\" .2\n"));
                          EXPECT_TRUE(said(WAITING, 2));
                          EXPECT_GT(page.state("version"), before);
                          write("scene.pbrt", "nonsense");
                          EXPECT_TRUE(said(WAITING, 3));
                          EXPECT_GT(page.state("version"), before); // the latest picture stays
                          ::kill(child, SIGINT);
                        });
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_EQ(o.err.find("http://"), o.err.rfind("http://")) << o.err;
}

TEST_F(Watch, GoesOnWhenThePageStopsARender) {
  const Outcome o = run({"render", "scene.pbrt", "--watch", "--live", "-o", "w.exr", "--integrator", "path",
                         "--spp", "100000000"},
                        [&](pid_t child) {
                          EXPECT_TRUE(said("http://", 1));
                          const LivePage page(contents(file(".stderr")));
                          EXPECT_TRUE(comesTo([&] { return page.state("version") > 0; }));
                          EXPECT_TRUE(has(page.answer("POST", "stop"), "204"));
                          EXPECT_TRUE(said(WAITING, 1));
                          write("scene.pbrt", "nonsense");
                          EXPECT_TRUE(said(WAITING, 2));
                          ::kill(child, SIGINT);
                        });
  EXPECT_EQ(o.status, 0) << o.err;
}

TEST_F(Watch, RendersTheFramesOfAnAnimationAgain) {
  const std::string moving = "Animate \"x\" \"float times\" [ 0 1 ] \"float values\" [ -.5 .5 ]\n" +
                             scene("", "Translate $x .5 0\nShape \"sphere\" \"float radius\" .3\n");
  write("scene.pbrt", moving);
  const Outcome o =
      run({"render", "scene.pbrt", "--watch", "--frames", "0:1", "-o", "f#.exr", "--integrator", "path"},
          [&](pid_t child) {
            EXPECT_TRUE(said(WAITING, 1));
            const std::vector<float> first = readImage(file("f0.exr")).pixels,
                                     second = readImage(file("f1.exr")).pixels;
            EXPECT_EQ(readImage(file("f1.exr")).width, 24);
            EXPECT_FALSE(first == second);
            write("scene.pbrt", moving + "Translate 0 .5 0\nShape \"sphere\" \"float radius\" .2\n");
            EXPECT_TRUE(said(WAITING, 2));
            EXPECT_FALSE(readImage(file("f0.exr")).pixels == first);
            EXPECT_FALSE(readImage(file("f1.exr")).pixels == second);
            ::kill(child, SIGINT);
          });
  EXPECT_EQ(o.status, 0) << o.err;
}

TEST_F(Watch, RefusesWhatMakesNoSense) {
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{"--check"}, {"--send-scene"}, {"--checkpoint", "c.rck"}}) {
    std::vector<std::string> words = {"render", "scene.pbrt", "--watch", "-o", "w.exr"};
    words.insert(words.end(), more.begin(), more.end());
    EXPECT_EQ(run(words).status, 2) << more[0];
  }
  EXPECT_EQ(run({"render", "scene.pbrt", "--send-scene"}).status, 2);
}

TEST_F(Watch, GoesOnWhenASceneIsNotLoadedInTime) {
  const std::string quick = contents(file("scene.pbrt"));
  write("scene.pbrt", slowScene());
  const Outcome o = run({"render", "scene.pbrt", "--watch", "-o", "w.exr", "--integrator", "path", "--spp",
                         "2", "--time-limit", "3s"},
                        [&](pid_t child) {
                          EXPECT_TRUE(said(WAITING, 1));
                          EXPECT_FALSE(exists("w.exr"));
                          write("scene.pbrt", quick);
                          EXPECT_TRUE(said(WAITING, 2));
                          EXPECT_TRUE(exists("w.exr"));
                          ::kill(child, SIGINT);
                        });
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_TRUE(has(o.err, "the time limit ended before the scene was loaded")) << o.err;
}

TEST_F(Watch, AChangeEndsLoading) {
  const std::string quick = contents(file("scene.pbrt"));
  write("scene.pbrt", slowScene());
  const Outcome o =
      run({"render", "scene.pbrt", "--watch", "-o", "w.exr", "--integrator", "path"}, [&](pid_t child) {
        sleepSeconds(1);
        write("scene.pbrt", quick);
        EXPECT_TRUE(said(WAITING, 1));
        EXPECT_TRUE(exists("w.exr"));
        ::kill(child, SIGINT);
      });
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_LT(o.seconds, 20);
}

TEST_F(Watch, ASignalEndsLoadingAtOnce) {
  write("scene.pbrt", slowScene());
  const Outcome o = runAMinute({"render", "scene.pbrt", "--watch", "-o", "w.exr"}, [](pid_t child) {
    EXPECT_TRUE(comesTo([&] { return processorSeconds(child) > 1; })); // earlier work takes milliseconds
    ::kill(child, SIGINT);
  });
  EXPECT_EQ(o.status, 130) << o.err;
}
