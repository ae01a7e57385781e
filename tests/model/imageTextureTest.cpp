/** @file
 * Pictures as textures: positions of pixels, encodings, edges, filtering against averages, missing and broken
 * files.
 */
#include <fstream>
#include <random>

#include "model/textureTesting.h"
#include "picturesWithAlpha.h"
#include "recurse/core/image/image.h"
#include "recurse/core/image/imageTexture.h"
#include "recurse/core/threads/parallel.h"
#include "recurse/core/threads/resources.h"
#include "recurse/model/scene/scene.h"
#include "recurse/scene/directives/loader.h"
#include "sanitized.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

std::string map(const std::string& file, const std::string& more = "") {
  return "\"string filename\" \"" + file + "\" " + more;
}

Rgb at(const Texture& t, double u, double v) { return t.value(flatPoint(u, v)); }

/** Reproducible value for each pixel. */
Rgb noisy(int x, int y) {
  const auto one = [&](uint64_t k) {
    return unitFloat(static_cast<uint32_t>(hashCombine(hashCombine(uint64_t(x), uint64_t(y)), k) >> 32));
  };
  return {one(1), one(2), one(3)};
}

/** Messages while a scene is built; `isBuilt`: whether the build must succeed. */
std::string toldOf(const std::string& scene, bool isBuilt) {
  Diagnostics diagnostics;
  const SceneDescription d =
      parseScene("Camera \"perspective\"\nWorldBegin\n" + scene, "test.pbrt", ".", diagnostics);
  EXPECT_FALSE(diagnostics.hasErrors()) << diagnostics.format();
  EXPECT_EQ(buildScene(d, {}, diagnostics) != nullptr, isBuilt);
  return diagnostics.format();
}
std::string complaintOf(const std::string& scene) { return toldOf(scene, false); }
void expectPart(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "wanted: " << part << "\nin: " << text;
}

} // namespace

TEST(ImageMap, PixelsAreWhereTheyBelong) {
  const Folder folder;
  const std::string file = folder.picture("grid.exr", 5, 3, noisy);
  for (const char* filter : {"point", "bilinear", "trilinear", "EWA"}) {
    const auto t = makeTexture("imagemap", map(file, std::string("\"string filter\" \"") + filter + "\""));
    for (int y = 0; y < 3; ++y)
      for (int x = 0; x < 5; ++x) // v = 0 is the lower edge
        expectNear(at(*t, (x + .5) / 5, 1 - (y + .5) / 3), noisy(x, y), 1e-5, filter);
  }
  const auto point = makeTexture("imagemap", map(file, "\"string filter\" \"point\""));
  expectNear(at(*point, 1.9 / 5, 1 - 1.1 / 3), noisy(1, 1), 1e-6);
  const auto bilinear = makeTexture("imagemap", map(file));
  expectNear(at(*bilinear, 2. / 5, 1 - 1.75 / 3),
             .375f * (noisy(1, 1) + noisy(2, 1)) + .125f * (noisy(1, 2) + noisy(2, 2)), 1e-5);
}

TEST(ImageMap, FloatTexturesTakeTheFirstChannel) {
  const Folder folder;
  const std::string file = folder.picture("grid.exr", 4, 4, noisy);
  const auto t = makeTexture("imagemap", map(file), false);
  EXPECT_NEAR(at(*t, .375, .875).r, noisy(1, 0).r, 1e-6);
  EXPECT_EQ(at(*t, .375, .875).g, at(*t, .375, .875).r);
  Image grey(2, 1, {"Y"});
  grey.pixels = {.25f, .75f};
  writeImage(folder.file("grey.exr"), grey);
  EXPECT_EQ(at(*makeTexture("imagemap", map(folder.file("grey.exr"))), .75, .5), Rgb(.75f));
}

TEST(ImageMap, ScaleThenInvert) {
  const Folder folder;
  const std::string file = folder.picture("c.exr", 2, 2, [](int, int) { return Rgb(.1f, .3f, .6f); });
  expectNear(at(*makeTexture("imagemap", map(file, "\"float scale\" 2")), .5, .5), {.2f, .6f, 1.2f}, 1e-6);
  expectNear(at(*makeTexture("imagemap", map(file, "\"float scale\" 2 \"bool invert\" true")), .5, .5),
             {.8f, .4f, 0}, 1e-6);
}

TEST(ImageMap, EncodingsOfEightBits) {
  const Folder folder;
  // writeImage encodes: 0.2159 is 128.
  const std::string file = folder.picture("c.png", 2, 2, [](int, int) { return Rgb(.2159f, 0, 1); });
  const double byte = 128. / 255, srgb = std::pow((byte + .055) / 1.055, 2.4);
  // 8-bit sRGB is stored with 11 bits of mantissa.
  expectNear(at(*makeTexture("imagemap", map(file)), .5, .5), {float(srgb), 0, 1}, srgb / 2000);
  expectNear(at(*makeTexture("imagemap", map(file, "\"string encoding\" \"sRGB\"")), .5, .5),
             {float(srgb), 0, 1}, srgb / 2000);
  expectNear(at(*makeTexture("imagemap", map(file, "\"string encoding\" \"linear\"")), .5, .5),
             {float(byte), 0, 1}, 1e-6);
  expectNear(at(*makeTexture("imagemap", map(file, "\"string encoding\" \"gamma 3\"")), .5, .5),
             {float(std::pow(byte, 3)), 0, 1}, 1e-4);
  const Textures none;
  for (const char* wrong : {"gamma", "gamma x", "gamma -1", "rec709"}) {
    Diagnostics diagnostics;
    EXPECT_FALSE(tryTexture("imagemap", map(file, std::string("\"string encoding\" \"") + wrong + "\""),
                            {none}, diagnostics))
        << wrong;
    expectPart(diagnostics.format(), "cannot be \"" + std::string(wrong) + "\"");
  }
}

TEST(ImageMap, ColoursAreNotMultipliedByAlpha) {
  const Folder folder;
  const std::string file = folder.file("alpha.png");
  std::ofstream(file, std::ios::binary) << PNG_WITH_ALPHA;
  const Rgb colour = at(*makeTexture("imagemap", map(file, "\"string filter\" \"point\"")), .25, .5);
  const Rgb stored(linearFromSrgb(200 / 255.f), linearFromSrgb(100 / 255.f), linearFromSrgb(50 / 255.f));
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(colour[c], stored[c], stored[c] / 1000);
}

TEST(ImageMap, AlphaIsLinear) {
  const Folder folder;
  const std::string file = folder.file("alpha.png");
  std::ofstream(file, std::ios::binary) << PNG_WITH_ALPHA;
  for (const char* encoding : {"", "\"string encoding\" \"sRGB\"", "\"string encoding\" \"gamma 2.2\""}) {
    const auto t = makeTexture(
        "imagemap",
        map(file, std::string("\"string channel\" \"alpha\" \"string filter\" \"point\" ") + encoding),
        false);
    EXPECT_NEAR(at(*t, .25, .5).r, 64 / 255., 1e-6) << encoding;
    EXPECT_NEAR(at(*t, .75, .5).r, 128 / 255., 1e-6) << encoding;
  }
}

TEST(ImageMap, AlphaOfAGifIsItsOwn) {
  using namespace std::string_literals;
  const Folder folder;
  const std::string file = folder.file("opaque.gif"); // one pixel of (200, 0, 0)
  std::ofstream(file, std::ios::binary)
      << "GIF89a\1\0\1\0\200\0\0\310\0\0\377\377\377,\0\0\0\0\1\0\1\0\0\2\2D\1\0;"s;
  const auto t = makeTexture("imagemap", map(file, "\"string channel\" \"alpha\""), false);
  EXPECT_EQ(at(*t, .5, .5).r, 1);
}

TEST(ImageMap, FilteringIsDoneInLinearLight) {
  const Folder folder;
  const std::string file =
      folder.picture("bw.png", 64, 64, [](int x, int y) { return Rgb(float((x + y) % 2)); });
  for (const char* filter : {"bilinear", "trilinear", "EWA"}) {
    const auto t = makeTexture("imagemap", map(file, std::string("\"string filter\" \"") + filter + "\""));
    EXPECT_NEAR(t->value(seen(flatPoint(.31, .52), .25f)).r, .5, .01) << filter;
  }
}

TEST(ImageMap, BeyondTheEdges) {
  const Folder folder;
  const std::string file = folder.picture("grid.exr", 4, 4, noisy);
  const auto with = [&](const char* wrap) {
    return makeTexture(
        "imagemap", map(file, std::string("\"string filter\" \"point\" \"string wrap\" \"") + wrap + "\""));
  };
  const auto pixel = [](int x, int y) { return noisy(x, y); };
  const auto repeat = with("repeat"), black = with("black"), clamp = with("clamp"),
             sphere = with("octahedralsphere");
  expectNear(at(*repeat, -.125, .375), pixel(3, 2), 1e-6);
  expectNear(at(*repeat, 3.125, -1.625), pixel(0, 2), 1e-6);
  expectNear(at(*black, -.125, .375), BLACK, 0);
  expectNear(at(*black, .5 + .125, 1.125), BLACK, 0);
  expectNear(at(*clamp, -.125, .375), pixel(0, 2), 1e-6);
  expectNear(at(*clamp, 1.3, 1.3), pixel(3, 0), 1e-6);
  // Beyond the left edge at the second row from the top: continues at the left edge in the second row from
  // the bottom.
  expectNear(at(*sphere, -.125, .375), pixel(0, 1), 1e-6);
  expectNear(at(*sphere, 1.375, .875), pixel(2, 3), 1e-6);
  expectNear(at(*sphere, .125, 1.125), pixel(3, 0), 1e-6);
  expectNear(at(*sphere, .125, -.375), pixel(3, 2), 1e-6);
}

TEST(ImageMap, FilteredValuesAreAveragesOverTheFootprint) {
  const Folder folder;
  // A wave that filters of one width and different shapes preserve, and one that they must remove.
  constexpr int N = 128;
  const auto f = [](double s, double t) {
    return .5 + .25 * std::sin(2 * M_PI * s) * std::cos(2 * M_PI * t) + .2 * std::sin(2 * M_PI * 16 * s);
  };
  const std::string file = folder.picture(
      "waves.exr", N, N, [&](int x, int y) { return Rgb(float(f((x + .5) / N, 1 - (y + .5) / N))); });
  const auto trilinear = makeTexture("imagemap", map(file, "\"string filter\" \"trilinear\""), false);
  const auto ewa =
      makeTexture("imagemap", map(file, "\"string filter\" \"EWA\" \"float maxanisotropy\" 16"), false);
  const auto slow = [](double s, double t) {
    return .5 + .25 * std::sin(2 * M_PI * s) * std::cos(2 * M_PI * t);
  };
  std::mt19937 random(8);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int i = 0; i < 100; ++i) {
    const double s = uniform(random), t = uniform(random);
    // A footprint of 8 pixels is one period of the fast wave.
    for (const Texture* texture : {trilinear.get(), ewa.get()})
      EXPECT_NEAR(texture->value(seen(flatPoint(s, t), 8.f / N)).r, slow(s, t), .03);
    // Long across the fast wave and short along it: it is averaged only along the long axis.
    SurfacePoint p = flatPoint(s, t);
    p.footprint = {glm::normalize(Vec3f(1, 0, -.125f)), 1.f / N};
    EXPECT_NEAR(ewa->value(p).r, slow(s, t), .06);
    p.footprint = {glm::normalize(Vec3f(0, 1, -.125f)), .5f / N};
    EXPECT_NEAR(ewa->value(p).r, f(s, t), .06);
  }
  // Footprint larger than the picture: its mean.
  for (const Texture* texture : {trilinear.get(), ewa.get()})
    EXPECT_NEAR(texture->value(seen(flatPoint(.3, .6), 4)).r, .5, .01);
}

TEST(ImageMap, OddSizesHaveTheirMean) {
  const Folder folder;
  Rgbd mean(0);
  const std::string file = folder.picture("odd.exr", 37, 21, [&](int x, int y) {
    mean += Rgbd(noisy(x, y)) / (37. * 21);
    return noisy(x, y);
  });
  const auto t = makeTexture("imagemap", map(file, "\"string filter\" \"trilinear\""));
  expectNear(t->value(seen(flatPoint(.3, .6), 4)), Rgb(mean), .04);
}

TEST(ImageMap, SharedFilesAndManyThreadsGiveTheSame) {
  const Folder folder;
  const std::string file = folder.picture("big.png", 300, 200, noisy);
  const auto a = makeTexture("imagemap", map(file, "\"string filter\" \"EWA\"")),
             b = makeTexture("imagemap", map(file, "\"string filter\" \"EWA\""));
  constexpr size_t POINTS = 4000;
  const auto value = [](const Texture& t, size_t i) {
    const double x = double(i) * .6180339887, y = double(i) * .7548776662;
    return t.value(seen(flatPoint(x - std::floor(x), y - std::floor(y)), std::exp2(-float(i % 12))));
  };
  std::vector<Rgb> one(POINTS), many(POINTS);
  for (size_t i = 0; i < POINTS; ++i) one[i] = value(*a, i);
  const ThreadPool pool(4);
  parallelFor(POINTS, [&](size_t i) { many[i] = value(*b, i); });
  EXPECT_EQ(one, many);
}

TEST(ImageMap, LittleMemoryGivesTheSame) {
  const Folder folder;
  const std::string file = folder.picture("p.exr", 300, 217, noisy);
  const auto values = [&] {
    const auto t = makeTexture("imagemap", map(file, "\"string filter\" \"trilinear\""));
    std::vector<Rgb> out;
    for (int i = 0; i < 500; ++i)
      out.push_back(t->value(seen(flatPoint(i * .0131, i * .0173), std::exp2(-float(i % 10)))));
    return out;
  };
  const std::vector<Rgb> truth = values();
  setTextureMemory(1); // all pixels are in files
  const std::vector<Rgb> little = values();
  setTextureMemory(0x1p31);
  EXPECT_TRUE(little == truth);
}

TEST(ImageMap, BadFilesAreNamedAtTheirPlace) {
  const Folder folder;
  const auto sceneWith = [](const std::string& texture) {
    return texture + "\nMaterial \"diffuse\" \"texture reflectance\" \"t\"\nShape \"sphere\"\n";
  };
  const auto textured = [&](const std::string& file) {
    return sceneWith("Texture \"t\" \"spectrum\" \"imagemap\"\n  \"string filename\" \"" + file + "\"");
  };
  const std::string missing = complaintOf(textured("none.png"));
  expectPart(missing, "test.pbrt:4:21: error: there is no file \"none.png\"");
  expectPart(missing, "^");

  std::ofstream(folder.file("empty.png")).close();
  expectPart(complaintOf(textured(folder.file("empty.png"))),
             "test.pbrt:4:21: error: " + folder.file("empty.png"));
  const std::string whole = folder.picture("whole.png", 64, 64, noisy);
  std::filesystem::resize_file(whole, std::filesystem::file_size(whole) / 2);
  expectPart(complaintOf(textured(whole)), "test.pbrt:4:21: error: " + whole + ": cannot be read");
  expectPart(complaintOf(textured(folder.file(""))), "test.pbrt:4:21: error: ");

  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    const std::string file =
        folder.picture("bad.exr", 8, 8, [&](int x, int y) { return Rgb(x == 5 && y == 2 ? bad : 1); });
    const std::string text = complaintOf(textured(file));
    expectPart(text, "test.pbrt:4:21: error: " + file + ": the pixel at column 5, row 2 is not finite");
  }
  expectPart(complaintOf("Material \"diffuse\" \"string normalmap\" \"none.png\"\nShape \"sphere\""),
             "test.pbrt:3:39: error: there is no file \"none.png\"");
}

TEST(ImageMap, TexturesThatNameEachOther) {
  expectPart(complaintOf("Texture \"a\" \"float\" \"scale\" \"texture tex\" \"b\"\n"
                         "Texture \"b\" \"float\" \"scale\" \"texture tex\" \"a\"\n"
                         "Material \"diffuse\" \"texture displacement\" \"a\"\nShape \"sphere\""),
             "depends on itself");
  expectPart(complaintOf("Texture \"a\" \"spectrum\" \"constant\"\nMaterial \"diffuse\" \"texture "
                         "displacement\" \"a\"\nShape \"sphere\""),
             "texture \"a\" is a spectrum texture; this parameter takes a float texture");
}

TEST(ImageMap, TexturesAndMaterialsOfTooManyLevelsOrPartsAreRefused) {
  const auto chain = [](int count, const auto& link) {
    std::string text;
    for (int i = 1; i <= count; ++i)
      text += link("\"t" + std::to_string(i) + "\"", "\"t" + std::to_string(i - 1) + "\"");
    return text;
  };
  const std::string first = "Texture \"t0\" \"spectrum\" \"constant\"\n";
  const auto deep = [&](int levels) {
    return first +
           chain(levels,
                 [](const std::string& name, const std::string& part) {
                   return "Texture " + name + " \"spectrum\" \"scale\" \"texture tex\" " + part + "\n";
                 }) +
           "Material \"diffuse\" \"texture reflectance\" \"t" + std::to_string(levels) +
           "\"\nShape \"sphere\"";
  };
  EXPECT_EQ(toldOf(deep(255), true), "");
  expectPart(complaintOf(deep(20000)), "nested more than 256 levels");
  const auto doubled = [&](int times) {
    return first +
           chain(times,
                 [](const std::string& name, const std::string& part) {
                   return "Texture " + name + " \"spectrum\" \"mix\" \"texture tex1\" " + part +
                          " \"texture tex2\" " + part + "\n";
                 }) +
           "Material \"diffuse\" \"texture reflectance\" \"t" + std::to_string(times) +
           "\"\nShape \"sphere\"";
  };
  EXPECT_EQ(toldOf(doubled(10), true), "");
  expectPart(complaintOf(doubled(40)), "more than 100000 textures");
  const auto mixed = [&](int levels) {
    return "MakeNamedMaterial \"t0\" \"string type\" \"diffuse\"\n" +
           chain(levels,
                 [](const std::string& name, const std::string& part) {
                   return "MakeNamedMaterial " + name + " \"string type\" \"mix\" \"string materials\" [ " +
                          part + " \"t0\" ]\n";
                 }) +
           "NamedMaterial \"t" + std::to_string(levels) + "\"\nShape \"sphere\"";
  };
  const std::string base = "MakeNamedMaterial \"t0\" \"string type\" \"diffuse\"\n";
  expectPart(complaintOf(base +
                         chain(40,
                               [](const std::string& name, const std::string& part) {
                                 return "MakeNamedMaterial " + name +
                                        " \"string type\" \"mix\" \"string materials\" [ " + part + " " +
                                        part + " ]\n";
                               }) +
                         "NamedMaterial \"t40\"\nShape \"sphere\""),
             "more than 100000 materials");
  EXPECT_EQ(toldOf(mixed(255), true), "");
  expectPart(complaintOf(mixed(20000)), "nested more than 256 levels");
}

TEST(ImageMap, PicturesThatRunOutOfMemoryAreNamed) {
  if (SANITIZED) GTEST_SKIP() << "sanitizers end a program that runs out of memory";
  const Folder folder;
  const std::string file = folder.picture("huge.exr", 16, 3, noisy);
  std::ifstream in(file, std::ios::binary);
  std::string bytes(std::istreambuf_iterator<char>(in), {});
  // Last column of the data window: 8 million columns of 3 rows.
  const std::string before("dataWindow\0box2i\0\x10\0\0\0", 21);
  const size_t at = bytes.find(before);
  ASSERT_NE(at, std::string::npos);
  bytes.replace(at + before.size() + 8, 4, std::string("\0\0\x80\0", 4));
  std::ofstream(file, std::ios::binary) << bytes;
  const MemoryCap cap(0.5e9);
  const std::string said =
      complaintOf("Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"" + file +
                  "\"\nMaterial \"diffuse\" \"texture reflectance\" \"t\"\n"
                  "Shape \"sphere\"");
  expectPart(said, "test.pbrt:3:");
  expectPart(said, "huge.exr: cannot be read: it needs more memory than is available");
  EXPECT_THROW(readImage(file), Error);
}
