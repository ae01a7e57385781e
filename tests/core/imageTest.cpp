/** @file
 * Image files: values survive writing and reading, and no partial file remains.
 */
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <random>
#include <sstream>

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "picturesWithAlpha.h"
#include "recurse/core/image/image.h"
#include "recurse/core/io/atomicFile.h"
#include "recurse/core/io/error.h"
#include "recurse/core/io/files.h"
#include "recurse/core/threads/resources.h"

using namespace recurse;
namespace fs = std::filesystem;

namespace {

class ImageFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = fs::temp_directory_path() / ("recurse-image-test-" + std::to_string(::getpid()));
    fs::create_directories(folder);
  }
  void TearDown() override { fs::remove_all(folder); }
  std::string file(const std::string& name) const { return (folder / name).string(); }
  size_t filesInFolder() const {
    return static_cast<size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
  }
  static std::string contents(const std::string& name) {
    std::ifstream in(name, std::ios::binary);
    std::ostringstream out;
    out << in.rdbuf();
    return out.str();
  }
  static Image picture() {
    Image image(5, 3, {"R", "G", "B"});
    for (size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = 0.02f * float(i);
    return image;
  }
  static std::string messageOf(const std::function<void()>& what) {
    try {
      what();
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  }
  fs::path folder;
};

} // namespace

TEST_F(ImageFiles, LinearFormatsKeepTheValues) {
  const Image image = picture();
  for (const char* name : {"a.exr", "a.pfm"}) {
    writeImage(file(name), image);
    const Image back = readImage(file(name));
    EXPECT_EQ(back.width, 5);
    EXPECT_EQ(back.height, 3);
    EXPECT_EQ(back.channels, image.channels) << name;
    EXPECT_EQ(back.pixels, image.pixels) << name;
  }
  writeImage(file("a.hdr"), image);
  const Image back = readImage(file("a.hdr"));
  for (size_t i = 0; i < image.pixels.size(); ++i) // a mantissa of 8 bits, shared by three channels
    EXPECT_NEAR(back.pixels[i], image.pixels[i], 0.004 * 2 * image.pixels[i / 3 * 3 + 2]);
}

TEST_F(ImageFiles, ColoursOfRgbeAreRounded) {
  Image image(64, 64, {"R", "G", "B"});
  double sum[3] = {}, stored[3] = {};
  std::mt19937 random(3);
  std::uniform_real_distribution<float> unit;
  for (float& x : image.pixels) x = unit(random);
  for (size_t i = 2; i < image.pixels.size(); i += 3) image.pixels[i] *= 0.1f;
  writeImage(file("a.hdr"), image);
  const Image back = readImage(file("a.hdr"));
  for (size_t i = 0; i < image.pixels.size(); ++i) {
    sum[i % 3] += double(image.pixels[i]);
    stored[i % 3] += double(back.pixels[i]);
  }
  for (const size_t c : {0, 1, 2}) EXPECT_NEAR(stored[c] / sum[c], 1, 1e-3) << c; // .96 for the last, if cut
}

TEST_F(ImageFiles, DisplayFormatsAreSrgb) {
  Image image = picture();
  image.pixels[0] = -1;
  image.pixels[1] = std::numeric_limits<float>::quiet_NaN();
  image.pixels[2] = std::numeric_limits<float>::infinity();
  for (const char* name : {"a.png", "a.tif", "a.tiff"}) {
    writeImage(file(name), image);
    const Image back = readImage(file(name));
    EXPECT_EQ(back.rgb(0, 0), Rgb(0, 0, 1)) << name;
    for (size_t i = 3; i < image.pixels.size(); ++i)
      EXPECT_NEAR(back.pixels[i], image.pixels[i], 0.005) << name;
  }
  // sRGB of linear 0.214041 is 0.5, and of twice the value 0.685; one stop doubles the value.
  Image grey(16, 16, {"R", "G", "B"});
  std::fill(grey.pixels.begin(), grey.pixels.end(), 0.2140411f);
  for (const char* name : {"g.jpg", "g.jpeg", "g.png"}) {
    writeImage(file(name), grey, {1});
    EXPECT_NEAR(readImage(file(name)).rgb(3, 3).g, 0.4280822f, 0.006f) << name;
  }
}

TEST_F(ImageFiles, LayersAndMetadataSurvive) {
  Image image(2, 2, {"R", "G", "B", "direct.R", "direct.G", "direct.B"});
  for (size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = float(i);
  image.metadata = {{"Software", "Recurse 9"}, {"recurse:scene", "a.pbrt"}, {"recurse:seed", "7"}};
  writeImage(file("l.exr"), image);
  EXPECT_NE(contents(file("l.exr")).find(std::string("chromaticities\0chromaticities\0", 30)),
            std::string::npos);
  Image back = readImage(file("l.exr"));
  ASSERT_EQ(back.channels.size(), 6u);
  for (const std::string& name : image.channels)
    EXPECT_EQ(back.at(1, 1)[back.channel(name)], image.at(1, 1)[image.channel(name)]) << name;
  EXPECT_EQ(back.channel("R"), 0);
  EXPECT_EQ(back.channel("nothing"), -1);
  for (const auto& [name, value] : image.metadata) EXPECT_EQ(back.metadata[name], value);
  writeImage(file("again.exr"), back); // the metadata of a file do not disturb the writer
  EXPECT_EQ(readImage(file("again.exr")).pixels, back.pixels);
}

TEST_F(ImageFiles, OtherChannelsAreSorted) {
  Image grey(2, 1, {"Y"});
  grey.pixels = {0.25f, 4};
  writeImage(file("y.exr"), grey);
  EXPECT_EQ(readImage(file("y.exr")).rgb(1, 0), Rgb(4));
  writeImage(file("y.png"), grey); // a grey channel becomes three
  EXPECT_EQ(readImage(file("y.png")).rgb(1, 0), Rgb(1));

  Image alpha(1, 1, {"A", "B", "G", "R"});
  alpha.pixels = {1, 0.3f, 0.2f, 0.1f};
  writeImage(file("a.exr"), alpha);
  const Image back = readImage(file("a.exr"));
  EXPECT_EQ(back.rgb(0, 0), Rgb(0.1f, 0.2f, 0.3f));
  EXPECT_EQ(back.channels.back(), "A");

  Image layer(1, 1, {"depth", "glass.R", "glass.G", "glass.B"});
  layer.pixels = {9, 1, 2, 3};
  writeImage(file("layer.exr"), layer);
  EXPECT_EQ(readImage(file("layer.exr")).rgb(0, 0), Rgb(1, 2, 3));

  Image two(1, 1, {"u", "v"});
  writeImage(file("two.exr"), two);
  EXPECT_NE(messageOf([&] { readImage(file("two.exr")); }).find("its channels are: u v"), std::string::npos);
}

TEST_F(ImageFiles, ColoursAreAsStoredBesideAlpha) {
  const auto expectColours = [](const Image& image, const std::string& name) {
    ASSERT_EQ(image.channels, (std::vector<std::string>{"R", "G", "B", "A"})) << name;
    const std::array<float, 3> codes = {200, 100, 50};
    for (size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(image.at(0, 0)[c], linearFromSrgb(codes[c] / 255), 1e-6) << name << " channel " << c;
    EXPECT_NEAR(image.at(0, 0)[3], 64 / 255.f, 1e-6) << name;
  };
  const std::map<std::string, std::string> files = {{"a.png", PNG_WITH_ALPHA}, {"a.tga", TGA_WITH_ALPHA}};
  for (const auto& [name, bytes] : files) {
    std::ofstream(file(name), std::ios::binary) << bytes;
    expectColours(readImage(file(name)), name);
    expectColours(readImage({name, std::make_shared<const std::string>(bytes)}), name + " in memory");
  }
  // Associated alpha by definition, even if a colour exceeds alpha.
  Image associated(1, 1, {"R", "G", "B", "A"});
  associated.pixels = {.2f, .1f, .5f, .25f};
  writeImage(file("a.exr"), associated);
  EXPECT_EQ(readImage(file("a.exr")).pixels, associated.pixels);
}

TEST_F(ImageFiles, SixteenBitIsSrgbToo) {
  // A PGM of one pixel, 16 bits, 32768/65535.
  std::ofstream(file("x.pgm"), std::ios::binary) << std::string("P5\n1 1\n65535\n\x80\x00", 15);
  EXPECT_NEAR(readImage(file("x.pgm")).rgb(0, 0).r, 0.2140411f, 1e-4f);
}

TEST_F(ImageFiles, ReadErrorsNameFileAndReason) {
  EXPECT_EQ(messageOf([&] { readImage(file("none.exr")); }),
            file("none.exr") + ": cannot be read: No such file or directory");
  EXPECT_NE(messageOf([&] { readImage(folder.string()); }).find("folder"), std::string::npos);
  for (const char* name : {"bad.exr", "bad.png", "bad.jpg", "bad.xyz"}) {
    std::ofstream(file(name)) << "this is no picture";
    const std::string message = messageOf([&] { readImage(file(name)); });
    EXPECT_EQ(message.find(file(name) + ": cannot be read: "), 0u) << message;
    EXPECT_GT(message.size(), file(name).size() + 20);
  }
  writeImage(file("cut.exr"), picture());
  fs::resize_file(file("cut.exr"), fs::file_size(file("cut.exr")) - 20);
  EXPECT_FALSE(messageOf([&] { readImage(file("cut.exr")); }).empty());
}

TEST_F(ImageFiles, WhatIsTooLargeInMemoryIsRefusedByName) {
  // A header of 8192x4096 pixels: 0.1 GB as bytes, and eight times as large as floats, in storage and as a
  // picture.
  const unsigned char header[18] = {0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x20, 0, 0x10, 24, 0};
  std::ofstream(file("a.tga"), std::ios::binary).write(reinterpret_cast<const char*>(header), 18) << "bytes";
  setMemoryLimit(0.5e9);
  const std::string said = messageOf([&] { readImage(file("a.tga")); });
  setMemoryLimit(INFINITY);
  EXPECT_NE(said.find("a.tga: a picture of 8192x4096 pixels needs about"), std::string::npos) << said;
}

TEST_F(ImageFiles, UnknownExtensionListsWhatIsAccepted) {
  for (const char* name : {"a.gifx", "a", "a.pbrt"}) {
    const std::string message = messageOf([&] { writeImage(file(name), picture()); });
    EXPECT_NE(message.find(".exr .hdr .pfm .png .jpg .jpeg .tif .tiff"), std::string::npos) << message;
    EXPECT_EQ(messageOf([&] { checkImageWritable(file(name)); }), message);
  }
  EXPECT_EQ(filesInFolder(), 0u);
}

TEST_F(ImageFiles, CheckLeavesNoTrace) {
  checkImageWritable(file("new.EXR"));
  EXPECT_EQ(filesInFolder(), 0u);
  EXPECT_NE(messageOf([&] { checkImageWritable(file("no/such/a.exr")); }).find("no such folder"),
            std::string::npos);
  fs::create_directory(file("folder.exr"));
  EXPECT_NE(messageOf([&] { checkImageWritable(file("folder.exr")); }).find("directory"), std::string::npos);
  std::ofstream(file("plain")) << "x";
  EXPECT_FALSE(messageOf([&] { checkImageWritable(file("plain/a.exr")); }).empty());
  EXPECT_FALSE(messageOf([&] { checkImageWritable(file(std::string(300, 'n') + ".exr")); }).empty());
}

TEST_F(ImageFiles, PermissionsAreRespected) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  fs::create_directory(file("closed"));
  fs::permissions(file("closed"), fs::perms::owner_read | fs::perms::owner_exec);
  EXPECT_NE(messageOf([&] { checkImageWritable(file("closed/a.exr")); }).find("Permission denied"),
            std::string::npos);
  EXPECT_NE(messageOf([&] { writeImage(file("closed/a.exr"), picture()); }).find("Permission denied"),
            std::string::npos);
}

TEST_F(ImageFiles, FailedWriteKeepsTheOldPicture) {
  for (const char* name : {"old.exr", "old.png", "old.jpg", "old.hdr", "old.pfm", "old.tif"}) {
    writeImage(file(name), picture());
    const std::string before = contents(file(name));
    Image large(300, 300, {"R", "G", "B"});
    std::mt19937 generator(1); // noise is incompressible
    for (float& value : large.pixels) value = float(generator() % 1000) / 1000;
    // A limit on the size of files fails at the same point as a full disk.
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    rlimit limit{}, small{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &limit), 0);
    small = limit;
    small.rlim_cur = 4096;
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    const std::string message = messageOf([&] { writeImage(file(name), large); });
    ::setrlimit(RLIMIT_FSIZE, &limit);
    std::signal(SIGXFSZ, handler);
    EXPECT_EQ(message, file(name) + ": cannot be written: File too large");
    EXPECT_TRUE(contents(file(name)) == before) << name;
  }
  EXPECT_EQ(filesInFolder(), 6u);
}

TEST_F(ImageFiles, TemporaryFilesGoWithTheirWriter) {
  writeFileAtomically(file("a.json"), "old");
  {
    AtomicFile unfinished(file("a.json"));
    unfinished.write("new", 3);
    EXPECT_EQ(filesInFolder(), 2u);
    EXPECT_EQ(contents(file("a.json")), "old");
  }
  EXPECT_EQ(filesInFolder(), 1u);
  AtomicFile interrupted(file("b.json"));
  removeTemporaryFiles();
  EXPECT_EQ(filesInFolder(), 1u);
}

TEST_F(ImageFiles, TemporaryFilesOfOthersStayWhatTheyAre) {
  const std::string prefix = ".recurse-" + std::to_string(::getpid()) + "-";
  unsigned used = 0;
  {
    const AtomicFile shown(file("a"));
    const std::string name = fs::directory_iterator(folder)->path().filename().string();
    ASSERT_TRUE(name.starts_with(prefix)) << name;
    used = static_cast<unsigned>(std::stoul(name.substr(prefix.size())));
  }
  // Files of processes with the same id in other containers.
  const std::string next = file(prefix + std::to_string(used + 1) + ".tmp"),
                    afterNext = file(prefix + std::to_string(used + 2) + ".tmp");
  for (const std::string& name : {next, afterNext}) std::ofstream(name) << "of another";
  writeFileAtomically(file("a"), "own");
  EXPECT_EQ(contents(file("a")), "own");
  for (const std::string& name : {next, afterNext}) EXPECT_EQ(contents(name), "of another");
  EXPECT_EQ(filesInFolder(), 3u);
}

TEST_F(ImageFiles, TemporaryFilesOfKilledRunsAreRemovedADayLater) {
  using std::chrono::hours;
  fs::create_directory(file("out"));
  const auto writtenBefore = [&](hours age, const std::string& name) {
    std::ofstream(file("out/" + name)) << "rest";
    fs::last_write_time(file("out/" + name), fs::file_time_type::clock::now() - age);
  };
  const std::string dead = ".recurse-999999999-"; // above the largest process id
  writtenBefore(hours(25), dead + "0.tmp");
  const std::vector<std::string> kept = {
      dead + "1.exr",     dead + ".tmp",       dead + "1-2.tmp",
      dead + "x.tmp",     dead + "1.tmp.tmp",  dead.substr(1) + "1.tmp",
      ".recurse-x-1.tmp", ".recurse--1-1.tmp", ".recurse-" + std::to_string(::getpid()) + "-1000000.tmp"};
  for (const std::string& name : kept) writtenBefore(hours(1000), name);
  writtenBefore(hours(23), dead + "2.tmp");
  fs::create_directory(file("out/" + dead + "3.tmp"));
  writeFileAtomically(file("out/a"), "own");
  EXPECT_FALSE(fs::exists(file("out/" + dead + "0.tmp")));
  for (const std::string& name : kept) EXPECT_TRUE(fs::exists(file("out/" + name))) << name;
  EXPECT_TRUE(fs::exists(file("out/" + dead + "2.tmp")));
  EXPECT_TRUE(fs::exists(file("out/" + dead + "3.tmp")));
}

TEST_F(ImageFiles, OpenPipesAreStreamsButOpenFoldersAreNot) {
  ASSERT_EQ(::mkfifo(file("pipe").c_str(), 0600), 0);
  EXPECT_FALSE(isOpenStream(file("pipe")));
  const int pipe = ::open(file("pipe").c_str(), O_RDWR), opened = ::open(folder.c_str(), O_RDONLY);
  EXPECT_TRUE(isOpenStream(file("pipe")));
  EXPECT_FALSE(isOpenStream(folder.string()));
  EXPECT_THROW(requireReadable(folder.string()), Error);
  ::close(pipe);
  ::close(opened);
}

TEST_F(ImageFiles, LinksModesAndDevicesStayWhatTheyAre) {
  writeFileAtomically(file("real"), "1");
  fs::permissions(file("real"), fs::perms::owner_read | fs::perms::owner_write);
  fs::create_symlink("real", file("link"));
  writeFileAtomically(file("link"), "2");
  EXPECT_TRUE(fs::is_symlink(file("link")));
  EXPECT_EQ(contents(file("real")), "2");
  EXPECT_EQ(fs::status(file("real")).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  writeFileAtomically("/dev/null", "gone");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}
