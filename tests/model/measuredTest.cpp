/** @file
 * MERL files: the value written for an angle is read at that angle, and broken files are explained.
 */
#include <cstring>
#include <filesystem>
#include <fstream>
#include <unistd.h>

#include "model/bsdfTesting.h"

using namespace recurse;

namespace {

using Table =
    std::function<Rgbd(double half, double difference, double azimuth)>; // [1/sr] as a function of angles

/** A file of the format: entries by the root of the half angle, by the difference angle and its azimuth. */
std::string merlFile(int halves, int differences, int azimuths, const Table& table) {
  std::string bytes;
  const auto put = [&](const auto& x) { bytes.append(reinterpret_cast<const char*>(&x), sizeof x); };
  for (const int32_t n : {halves, differences, azimuths}) put(n);
  const double scale[3] = {1.0 / 1500, 1.15 / 1500, 1.66 / 1500};
  for (int c = 0; c < 3; ++c)
    for (int i = 0; i < halves; ++i)
      for (int j = 0; j < differences; ++j)
        for (int k = 0; k < azimuths; ++k)
          put(table(square(double(i) / halves) * M_PI / 2, double(j) / differences * M_PI / 2,
                    double(k) / azimuths * M_PI)[c] /
              scale[c]);
  return bytes;
}

/** Content of scenes/materials/satin.binary: a synthetic cloth, as a small file of the format. */
Rgbd satin(double half, double difference, double) {
  const double t = std::min(half, 1.5), a = 0.18, c = std::cos(difference);
  const double d = std::exp(-square(std::tan(t) / a)) / (M_PI * a * a * std::pow(std::cos(t), 4));
  const double gloss = (0.04 + 0.96 * std::pow(1 - c, 5)) * std::min(d, 1e3) / 4 / square(std::max(c, 0.2)) *
                       (difference > 1.2 ? 0.6 : 1);
  return Rgbd(0.35, 0.22, 0.12) / M_PI + gloss * 0.5;
}

std::string contents(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

class Measured : public ::testing::Test {
 protected:
  void SetUp() override {
    directory = ::testing::TempDir() + "measuredTest." + std::to_string(::getpid());
    std::filesystem::create_directory(directory);
  }
  void TearDown() override { std::filesystem::remove_all(directory); }
  std::unique_ptr<Material> load(const std::string& bytes, Diagnostics& diagnostics) const {
    std::ofstream(directory + "/x.binary", std::ios::binary) << bytes;
    return plugIns().materials.make(
        parseParameterText("measured", "\"string filename\" \"" + directory + "/x.binary\""), {textures, {}},
        diagnostics);
  }
  std::string complaint(const std::string& bytes) const {
    Diagnostics diagnostics;
    EXPECT_FALSE(load(bytes, diagnostics));
    return diagnostics.format();
  }
  NoTextures textures;
  std::string directory;
};

} // namespace

TEST_F(Measured, FindsEveryAngle) {
  // Periodic in the azimuth, so that both directions agree; nearly linear between the entries.
  const Table smooth = [](double half, double difference, double azimuth) {
    return Rgbd(0.1 + 0.05 * half, 0.1 + 0.05 * difference, 0.1 + 0.03 * std::cos(2 * azimuth));
  };
  Diagnostics diagnostics;
  const auto material = load(merlFile(90, 90, 180, smooth), diagnostics);
  ASSERT_TRUE(material) << diagnostics.format();
  BsdfArena arena;
  const Bsdf* bsdf = material->bsdfAt(flatPoint(), arena);
  TestRandom random(3);
  for (int i = 0; i < 20000; ++i) {
    // Directions from angles by the definition (Rusinkiewicz 1998): the difference vector is the first
    // direction in the frame where the half vector is the normal.
    const double half = std::acos(1 - double(random.next())), phi = 2 * M_PI * double(random.next());
    const double difference = std::acos(double(random.next())), azimuth = M_PI * double(random.next());
    const Vec3d d(std::sin(difference) * std::cos(azimuth), std::sin(difference) * std::sin(azimuth),
                  std::cos(difference));
    const auto toWorld = [&](const Vec3d& v) {
      const Vec3d tilted(v.x * std::cos(half) + v.z * std::sin(half), v.y,
                         v.z * std::cos(half) - v.x * std::sin(half));
      return Vec3f(Vec3d(tilted.x * std::cos(phi) - tilted.y * std::sin(phi),
                         tilted.x * std::sin(phi) + tilted.y * std::cos(phi), tilted.z));
    };
    const Vec3f a = toWorld(d), b = toWorld({-d.x, -d.y, d.z});
    if (a.z < 0.01f || b.z < 0.01f || half < 0.01 || difference < 0.01) continue;
    const Rgbd expected =
        smooth(std::min(half, M_PI / 2 * square(89.0 / 90)), // the last entry is constant beyond
               std::min(difference, M_PI / 2 * 89 / 90), azimuth);
    const Rgbd found(bsdf->value(a, b));
    for (int c = 0; c < 3; ++c)
      ASSERT_NEAR(found[c], expected[c], 2e-4) << c << " " << half << " " << difference;
  }
}

TEST_F(Measured, SatinIsWhatItSays) {
  const std::string made = merlFile(24, 10, 12, satin);
  const std::string stored = contents("scenes/materials/satin.binary");
  ASSERT_EQ(made.size(), stored.size());
  ASSERT_EQ(made.substr(0, 12), stored.substr(0, 12));
  for (size_t i = 12; i < made.size(); i += 8) {
    double a = 0, b = 0;
    std::memcpy(&a, &made[i], 8);
    std::memcpy(&b, &stored[i], 8);
    ASSERT_NEAR(a, b, 1e-9 * a);
  }
}

TEST_F(Measured, RefusesBrokenFiles) {
  const std::string good = merlFile(4, 3, 5, satin);
  EXPECT_NE(complaint("").find("shorter than the header"), std::string::npos);
  EXPECT_NE(complaint(good.substr(0, 11)).find("shorter than the header"), std::string::npos);
  EXPECT_NE(complaint(std::string("tensor_file\0and more", 20)).find("x.binary: at byte 12: version"),
            std::string::npos);
  EXPECT_NE(complaint("P6 640 480 255 ").find("no MERL file"), std::string::npos);
  for (const int32_t size : {0, -1, 1, 1025, 0x7fffffff}) {
    std::string bytes = good;
    std::memcpy(&bytes[4], &size, 4);
    EXPECT_NE(complaint(bytes).find("its header has 4 x " + std::to_string(size) + " x 5"),
              std::string::npos);
  }
  for (const size_t length : {size_t(12), size_t(13), good.size() / 2, good.size() - 1})
    EXPECT_NE(
        complaint(good.substr(0, length))
            .find("ends after " + std::to_string(length) + " of " + std::to_string(good.size()) + " bytes"),
        std::string::npos);
  EXPECT_NE(complaint(good + "x").find("has more data after the " + std::to_string(good.size())),
            std::string::npos);
  for (const double value : {double(NAN), double(INFINITY), 1e31}) {
    std::string bytes = good;
    std::memcpy(&bytes[12 + 8 * 7], &value, 8);
    EXPECT_NE(complaint(bytes).find("an invalid reflectance at byte 68"), std::string::npos);
  }
  EXPECT_NE(complaint(good.substr(0, 20)).find("measured:1:"), std::string::npos) << "no place is named";
  Diagnostics diagnostics;
  EXPECT_TRUE(load(good, diagnostics));
}
