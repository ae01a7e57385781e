/** @file
 * `recurse render --time-of-flight`, and films: animated PNG and, by ffmpeg, MP4.
 */
#include "program.h"

#include <bit>
#include <cmath>
#include <cstdint>

#include "recurse/core/image/image.h"

using namespace programTesting;
using recurse::Image;
using recurse::readImage;

namespace {

uint32_t bigEndian(const std::string& bytes, size_t at) {
  uint32_t value = 0;
  for (size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes.at(at + i));
  return value;
}

std::string bigEndian(uint32_t value) {
  std::string out;
  for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(value >> shift);
  return out;
}

/** CRC-32 bit by bit. */
uint32_t checksum(const std::string& bytes) {
  uint32_t crc = ~0u;
  for (const char byte : bytes)
    for (int bit = 0; bit < 8; ++bit) {
      const bool odd = (crc ^ static_cast<uint32_t>(static_cast<unsigned char>(byte) >> bit)) & 1;
      crc = crc >> 1 ^ (odd ? 0xedb88320u : 0);
    }
  return ~crc;
}

struct Chunk {
  std::string type, data;
  std::string bytes() const {
    return bigEndian(static_cast<uint32_t>(data.size())) + type + data + bigEndian(checksum(type + data));
  }
};

/** Chunks of a PNG file; verifies their checksums. */
std::vector<Chunk> chunksOf(const std::string& png) {
  std::vector<Chunk> chunks;
  for (size_t at = 8; at < png.size();) {
    const size_t length = bigEndian(png, at);
    chunks.push_back({png.substr(at + 4, 4), png.substr(at + 8, length)});
    EXPECT_EQ(bigEndian(png, at + 8 + length), checksum(chunks.back().type + chunks.back().data));
    at += length + 12;
  }
  return chunks;
}

class TimeOfFlight : public Program {
 protected:
  /** Frames of an animated PNG as pictures; verifies their numbering. */
  std::vector<Image> framesOf(const std::string& name, uint32_t perSecond = 24) const {
    const std::string png = contents(file(name));
    std::string header;
    std::vector<std::string> data;
    uint32_t sequence = 0, announced = 0;
    for (const Chunk& c : chunksOf(png)) {
      if (c.type == "IHDR") header = c.bytes();
      if (c.type == "acTL") announced = bigEndian(c.data, 0);
      if (c.type == "fcTL") {
        EXPECT_EQ(bigEndian(c.data, 0), sequence++);
        EXPECT_EQ(bigEndian(c.data, 20), 1u << 16 | perSecond) << "duration of a frame";
        data.emplace_back();
      }
      if (c.type == "fdAT") {
        EXPECT_EQ(bigEndian(c.data, 0), sequence++);
      }
      if (c.type == "IDAT" || c.type == "fdAT")
        data.back() += Chunk{"IDAT", c.data.substr(c.type == "IDAT" ? 0 : 4)}.bytes();
    }
    EXPECT_EQ(data.size(), announced);
    std::vector<Image> frames;
    for (const std::string& one : data) {
      write("one.png", png.substr(0, 8) + header + one + Chunk{"IEND", ""}.bytes());
      frames.push_back(readImage(file("one.png")));
    }
    return frames;
  }
  /** Renders the scene by `path`. */
  Outcome render(const std::vector<std::string>& more, const std::string& sceneFile = "scene.pbrt") const {
    std::vector<std::string> words = {"render", sceneFile, "--integrator", "path"};
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
  }
  void fails(const std::vector<std::string>& more, const std::string& words) const {
    const Outcome o = render(more);
    EXPECT_NE(o.status, 0);
    EXPECT_TRUE(has(o.err, words)) << o.err;
    for (const char* name : {"f.png", "f.apng", "f.mp4", "f.exr"}) EXPECT_FALSE(exists(name)) << name;
  }
  /** Runs the program with the PATH `folder`/bin. */
  int runWithOwnPath(const std::string& arguments) const {
    return std::system(("cd '" + folder + "' && PATH='" + folder +
                        "/bin' '" RECURSE_PROGRAM "' render scene.pbrt "
                        "-q --integrator path " +
                        arguments + " 2>log")
                           .c_str());
  }
  void writeFfmpeg(const std::string& script) const {
    std::filesystem::create_directory(file("bin"));
    write("bin/ffmpeg", "#!/bin/sh\n" + script);
    std::filesystem::permissions(file("bin/ffmpeg"), std::filesystem::perms::owner_all);
  }
};

} // namespace

TEST_F(TimeOfFlight, FilmShowsTheLayersWithOneExposure) {
  const Outcome o = render({"--time-of-flight", "2.5:5:5", "-o", "f.exr", "-o", "f.png", "-o", "f.jpg",
                            "--exposure", "p90", "--tonemap", "none"});
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_TRUE(has(o.err, "written: f.exr, f.png, f.jpg")) << o.err;
  const Image all = readImage(file("f.exr"));
  std::vector<std::string> names;
  for (size_t c = 3; c < all.channels.size(); c += 3) names.push_back(all.channels[c]);
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names, (std::vector<std::string>{"after.R", "before.R", "frame-0000.R", "frame-0001.R",
                                             "frame-0002.R", "frame-0003.R", "frame-0004.R"}));
  const std::vector<Image> frames = framesOf("f.png");
  ASSERT_EQ(frames.size(), 5u);
  const double scale =
      std::exp2(std::stod(readImage(file("f.png")).metadata.at("recurse:developed").substr(11)));
  size_t shown = 0;
  for (int y = 0; y < all.height; ++y)
    for (int x = 0; x < all.width; ++x) {
      double sum = 0;
      for (size_t c = 3; c < all.channels.size(); ++c)
        if (all.channels[c].ends_with(".R")) sum += double(all.at(x, y)[c]);
      EXPECT_NEAR(sum, double(all.at(x, y)[0]), 1e-5 * double(all.at(x, y)[0]));
      for (size_t i = 0; i < frames.size(); ++i) {
        const double linear =
            std::min(1.0, scale * double(all.at(x, y)[all.channel("frame-000" + std::to_string(i) + ".R")]));
        EXPECT_NEAR(double(frames[i].at(x, y)[0]), linear, 0.01) << i;
        shown += linear > 0.1;
      }
    }
  EXPECT_GT(shown, 100u);
  // Film made again from the layers.
  const Outcome again = run({"develop", "f.exr", "-o", "g.apng", "--exposure", "p90", "--tonemap", "none"});
  ASSERT_EQ(again.status, 0) << again.err;
  const std::vector<Image> developed = framesOf("g.apng");
  ASSERT_EQ(developed.size(), frames.size());
  for (size_t i = 0; i < frames.size(); ++i) EXPECT_EQ(developed[i].pixels, frames[i].pixels) << i;
  // The picture has all light, as without the option.
  ASSERT_EQ(render({"-o", "still.exr", "-o", "still.jpg", "--exposure", "p90", "--tonemap", "none"}).status,
            0);
  const Image still = readImage(file("still.exr"));
  for (int y = 0; y < all.height; ++y)
    for (int x = 0; x < all.width; ++x)
      EXPECT_NEAR(double(all.at(x, y)[1]), double(still.at(x, y)[1]), 1e-5 * double(still.at(x, y)[1]));
  EXPECT_EQ(readImage(file("f.jpg")).pixels, readImage(file("still.jpg")).pixels);
}

TEST_F(TimeOfFlight, GoesWithPathsAndCheckpoints) {
  ASSERT_EQ(render({"--time-of-flight", "2:6:4", "--paths", "LDE", "-o", "a.exr"}).status, 0);
  ASSERT_EQ(render({"--paths", "LDE", "-o", "b.exr"}).status, 0);
  const Image a = readImage(file("a.exr")), b = readImage(file("b.exr"));
  EXPECT_EQ(a.rgb(12, 14), b.rgb(12, 14));
  const std::vector<std::string> same = {"--time-of-flight", "2:6:4", "--checkpoint", "c",
                                         "--resume",         "-o",    "c.exr"};
  ASSERT_EQ(render(same).status, 0);
  ASSERT_EQ(render(same).status, 0) << "a render that is complete";
  fails({"--time-of-flight", "2:7:4", "--checkpoint", "c", "--resume", "-o", "f.exr"},
        "time of flight: 2:6:4");
}

TEST_F(TimeOfFlight, FramesThatMissAllLightSayWhereItArrives) {
  const std::string words =
      "warning: no light arrives within the frames, at path lengths from 100 to 200: all "
      "light arrives between lengths ";
  for (const std::string integrator : {"path", "photonmap", "bdpt", "lightpath"}) {
    SCOPED_TRACE(integrator);
    const auto tried = [&](const std::string& frames) {
      const Outcome o = run(
          {"render", "scene.pbrt", "--time-of-flight", frames, "--integrator", integrator, "-o", "f.png"});
      EXPECT_EQ(o.status, 0) << o.err;
      return o.err;
    };
    const std::string err = tried("100:200:4");
    const size_t at = err.find(words);
    ASSERT_NE(at, std::string::npos) << err;
    double least = 0, most = 0;
    ASSERT_EQ(std::sscanf(err.c_str() + at + words.size(), "%lf and %lf", &least, &most), 2);
    EXPECT_GT(least, 0);
    EXPECT_LT(most, 100);
    // These lengths have all the light.
    const auto lengths = [](double from, double to) {
      return std::to_string(from) + ":" + std::to_string(to);
    };
    EXPECT_FALSE(has(tried(lengths(0.99 * least, 1.01 * most) + ":3"), "no light arrives"));
    EXPECT_TRUE(has(tried(lengths(0, 0.99 * least) + ":3"), "no light arrives"));
    EXPECT_TRUE(has(tried(lengths(1.01 * most, 2 * most) + ":3"), "no light arrives"));
  }
}

TEST_F(TimeOfFlight, ErrorsSayWhatToDo) {
  const auto failsFor = [&](const std::string& value, const std::string& words) {
    fails({"--time-of-flight", value, "-o", "f.png"}, words);
  };
  failsFor("1:2", "FROM:TO:FRAMES");
  failsFor("1:a:3", "'a'");
  failsFor("3:3:5", "TO must be larger");
  failsFor("1:2:0", "from 1 to 9999");
  failsFor("1e6:1000001:9000", "too short");
  failsFor("0:1e31:9", "'0:1e31:9': lengths are from -1e30 to 1e30");
  failsFor("-1e31:0:9", "from -1e30 to 1e30");
  fails({"--time-of-flight", "1:2:3", "--class", "d=LDE", "-o", "f.png"}, "cannot be combined with --class");
  fails({"--time-of-flight", "1:2:3", "--frames", "0:3", "-o", "f.png"}, "cannot be combined with --frames");
  fails({"--time-of-flight", "1:2:3", "--frame-rate", "0", "-o", "f.png"}, "--frame-rate: '0'");
  fails({"-o", "f.apng"}, "f.apng: is a film; it needs --frames or --time-of-flight");
  const Outcome named =
      run({"render", "scene.pbrt", "--integrator", "whitted", "--time-of-flight", "1:2:3", "-o", "f.png"});
  EXPECT_EQ(named.status, 2) << named.err;
  EXPECT_TRUE(has(named.err, "--integrator: \"whitted\" does not measure the lengths of paths")) << named.err;
  fails({"--time-of-flight", "1:2:3", "--white-balance", "auto", "-o", "f.png"}, "each frame of f.png");
  for (const std::string toneMap : {"reinhard", "drago", "durand"})
    fails({"--time-of-flight", "1:2:3", "--tonemap", toneMap, "-o", "f.png"},
          "--tonemap: " + toneMap + " would adapt to each frame of f.png");
  ASSERT_EQ(
      render({"--time-of-flight", "2:6:2", "--tonemap", "reinhard \"float white\" 4", "-o", "g.png"}).status,
      0);
  ASSERT_EQ(render({"-o", "still.exr"}).status, 0);
  const Outcome still = run({"develop", "still.exr", "-o", "f.apng"});
  EXPECT_NE(still.status, 0);
  EXPECT_TRUE(has(still.err, "f.apng: the picture has no frames")) << still.err;
  write("whitted.pbrt", scene("Integrator \"whitted\"\n"));
  const Outcome o = run({"render", "whitted.pbrt", "--time-of-flight", "1:2:3", "-o", "f.png"});
  EXPECT_EQ(o.status, 3) << o.err;
  EXPECT_TRUE(has(o.err, "whitted.pbrt:5:12: error: \"whitted\" does not measure")) << o.err;
  EXPECT_TRUE(has(o.err, "^") && has(o.err, " bdpt lightpath vcm simplephotonmap photonmap")) << o.err;
  write("glow.pbrt", "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"rgb Le\" [ 1 1 1 ]\n" +
                         scene("", "MediumInterface \"m\" \"\"\nMaterial \"interface\"\nShape \"sphere\"\n"));
  const Outcome glow = render({"--time-of-flight", "1:2:3", "-o", "f.png"}, "glow.pbrt");
  EXPECT_NE(glow.status, 0);
  EXPECT_TRUE(has(glow.err, "medium that emits light")) << glow.err;
}

TEST_F(TimeOfFlight, AnimationsAreFilmsToo) {
  write("film.pbrt", "Animate \"x\" \"float times\" [ 0 2 ] \"float values\" [ -.5 .5 ]\n" +
                         scene("", "Translate $x .5 0\nShape \"sphere\" \"float radius\" .3\n"));
  const Outcome o =
      render({"--frames", "0:2", "-o", "f.apng", "-o", "g#.png", "--frame-rate", "5"}, "film.pbrt");
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_TRUE(has(o.err, "written: f.apng")) << o.err;
  const std::vector<Image> frames = framesOf("f.apng", 5);
  ASSERT_EQ(frames.size(), 3u);
  for (size_t i = 0; i < 3; ++i)
    EXPECT_EQ(frames[i].pixels, readImage(file("g" + std::to_string(i) + ".png")).pixels) << i;
  EXPECT_NE(frames[0].pixels, frames[2].pixels);
}

TEST_F(TimeOfFlight, FfmpegMakesMp4WhereItIsInstalled) {
  const std::string arguments = "--time-of-flight 2:6:4 -o f.mp4 --frame-rate 12";
  std::filesystem::create_directory(file("bin"));
  EXPECT_NE(runWithOwnPath(arguments), 0);
  EXPECT_TRUE(has(contents(file("log")), "f.mp4: needs the program ffmpeg")) << contents(file("log"));
  EXPECT_TRUE(has(contents(file("log")), "apt install ffmpeg"));
  // A substitute, which writes its arguments and the names of its input pictures.
  writeFfmpeg("echo \"$@\" > film.mp4\nfor i in *.png; do echo $i >> film.mp4; done\n");
  ASSERT_EQ(runWithOwnPath(arguments), 0) << contents(file("log"));
  const std::string film = contents(file("f.mp4"));
  EXPECT_TRUE(has(film, "-framerate 12 -i %06d.png")) << film;
  EXPECT_TRUE(has(film, "000000.png\n000001.png\n000002.png\n000003.png\n")) << film;
  std::filesystem::remove(file("f.mp4"));
  writeFfmpeg("echo no such codec >&2\nexit 1\n");
  EXPECT_NE(runWithOwnPath(arguments), 0);
  EXPECT_TRUE(has(contents(file("log")), "f.mp4: ffmpeg failed: no such codec")) << contents(file("log"));
  EXPECT_FALSE(exists("f.mp4"));
}

TEST_F(TimeOfFlight, AFilmThatCannotBeWrittenLosesNoOtherFilm) {
  write("scene.pbrt", "Animate \"x\" \"float times\" [ 0 2 ] \"float values\" [ -.5 .5 ]\n" +
                          scene("", "Translate $x .5 0\nShape \"sphere\" \"float radius\" .3\n"));
  writeFfmpeg("echo no such codec >&2\nexit 1\n");
  EXPECT_NE(runWithOwnPath("--frames 0:1 -o a.mp4 -o b.apng -o c.apng"), 0);
  EXPECT_TRUE(has(contents(file("log")), "a.mp4: ffmpeg failed: no such codec")) << contents(file("log"));
  EXPECT_FALSE(exists("a.mp4"));
  EXPECT_EQ(framesOf("b.apng").size(), 2u);
  EXPECT_EQ(framesOf("c.apng").size(), 2u);
}
