/** @file
 * Measured BRDFs in the adaptive parameterization, tabulated from BRDFs in closed form: lookups return the
 * tabulated values, and broken files are explained.
 */
#include <fstream>

#include "bsdfs/measured/adaptiveBrdf.h"
#include "bsdfs/measured/tensorFile.h"
#include "model/adaptiveBrdfTesting.h"
#include "model/bsdfTesting.h"
#include "recurse/scene/parameters/spectrum.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

constexpr const char* NAME = "a.bsdf";

Tabulation roughMetal(const Vec2f& alpha, size_t resolution) {
  Tabulation t;
  t.facets = {MicrofacetKind::TROWBRIDGE_REITZ, alpha};
  t.brdf = [facets = t.facets](const Vec3f& a, const Vec3f& b) {
    return double(facets.reflection(a, b, halfVector(a, b)));
  };
  t.thetas = Tabulation::nodes(0, PI / 2, resolution / 2 + 1);
  t.resolution = resolution;
  return t;
}

/** Mean error of the flux to directions of a cosine distribution, relative to its mean. */
double meanError(const AdaptiveBrdf& brdf, const Tabulation& t, uint32_t seed) {
  TestRandom random(seed);
  double error = 0, sum = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3f a = cosineHemisphere(random.next2()), b = cosineHemisphere(random.next2());
    const double expected = t.brdf(a, b);
    error += std::abs(double(brdf.value(a, b).g) - expected);
    sum += expected;
  }
  return error / sum;
}

double meanError(const Tabulation& t) { return meanError(AdaptiveBrdf(NAME, adaptiveFile(t)), t, 5); }

Tabulation anisotropic(int symmetry) {
  Tabulation t = roughMetal({0.2f, 0.5f}, 24);
  t.phis = Tabulation::nodes(-PI, -PI + 2 * PI / static_cast<float>(symmetry), size_t(48 / symmetry) + 1);
  return t;
}

std::string complaint(const std::string& bytes) {
  try {
    const AdaptiveBrdf brdf(NAME, bytes);
    return "none";
  } catch (const Error& e) {
    return e.what();
  }
}

/** Error message for a valid file with one change. */
template <class F> std::string complaintAfter(const F& change) {
  Tabulation t = roughMetal(Vec2f(0.5f), 4);
  TensorFields fields = Tabulator(t).fields();
  change(fields);
  return complaint(tensorFile(fields));
}

void expectComplaint(const std::string& found, const std::string& expected) {
  EXPECT_NE(found.find(expected), std::string::npos) << found;
  EXPECT_EQ(found.find(NAME), 0u) << "the file's name comes first: " << found;
}

} // namespace

TEST(AdaptiveBrdf, MatchesTheRoughMetalThatWasTabulated) {
  const double coarse = meanError(roughMetal(Vec2f(0.3f), 16)), fine = meanError(roughMetal(Vec2f(0.3f), 64));
  EXPECT_LT(fine, 0.01);
  EXPECT_LT(fine, coarse / 4) << "the error goes with the square of the width of cells";
}

TEST(AdaptiveBrdf, MatchesWhateverTheFacetsAreSpreadAs) {
  Tabulation t = roughMetal(Vec2f(0.6f), 64);
  t.brdf = [](const Vec3f&, const Vec3f&) { return 0.5 / M_PI; };
  EXPECT_LT(meanError(t), 0.01);
  t.relative = false;
  EXPECT_LT(meanError(t), 0.01) << "without the factor of the facets";
  const AdaptiveBrdf brdf(NAME, adaptiveFile(t));
  for (const double degrees : {0.0, 40.0, 70.0}) {
    const auto a = static_cast<float>(glm::radians(degrees));
    EXPECT_NEAR(double(brdf.albedo({std::sin(a), 0, std::cos(a)}).g), 0.5, 0.03) << degrees;
  }
}

TEST(AdaptiveBrdf, AzimuthsMatterToBrushedMetal) {
  const Tabulation whole = anisotropic(1);
  const AdaptiveBrdf reference(NAME, adaptiveFile(whole));
  EXPECT_TRUE(reference.isAnisotropic());
  EXPECT_LT(meanError(reference, whole, 7), 0.05);
  for (const int symmetry : {2, 4}) {
    const Tabulation t = anisotropic(symmetry);
    const AdaptiveBrdf part(NAME, adaptiveFile(t));
    EXPECT_LT(meanError(part, t, 7), 0.05) << symmetry;
    TestRandom random(11);
    for (int i = 0; i < 2000; ++i) {
      const Vec3f a = cosineHemisphere(random.next2()), b = cosineHemisphere(random.next2());
      const float expected = part.value(a, b).g, density = part.pdf(a, b);
      for (const Vec3f& flip : {Vec3f(-1, -1, 1), Vec3f(1, -1, 1), Vec3f(-1, 1, 1)}) {
        if (symmetry == 2 && flip.x != flip.y) continue;
        ASSERT_NEAR(part.value(a * flip, b * flip).g, expected, 1e-4f * (1 + expected)) << symmetry;
        ASSERT_NEAR(part.pdf(a * flip, b * flip), density, 1e-4f * (1 + density)) << symmetry;
      }
    }
  }
}

TEST(AdaptiveBrdf, SamplesOfBrushedMetalFollowTheirDensity) {
  for (const int symmetry : {1, 2, 4}) {
    const AdaptiveBrdf brdf(NAME, adaptiveFile(anisotropic(symmetry)));
    for (const Vec3f& w : {Vec3f(.3f, .5f, .8f), Vec3f(-.7f, .2f, .3f), Vec3f(.4f, -.6f, .1f)}) {
      const Vec3f wi = glm::normalize(w);
      // Integral of a smooth function by samples, and by a grid of directions.
      const auto smooth = [](const Vec3f& wo) { return 1 + 0.5 * double(wo.x) - 0.7 * double(wo.y * wo.z); };
      TestRandom random(3);
      double bySamples = 0, byGrid = 0;
      constexpr int N = 40000, GRID = 600;
      for (int i = 0; i < N; ++i) {
        const Vec2f u = random.next2();
        if (const auto wo = brdf.sample(wi, u, random.next())) bySamples += smooth(*wo) / N;
      }
      for (int i = 0; i < GRID * GRID; ++i) {
        const double z = (i % GRID + 0.5) / GRID, phi = 2 * M_PI * (i / GRID + 0.5) / GRID; // NOLINT
        const Vec3f wo(Vec3d(std::sqrt(1 - z * z) * std::cos(phi), std::sqrt(1 - z * z) * std::sin(phi), z));
        byGrid += smooth(wo) * double(brdf.pdf(wi, wo)) * 2 * M_PI / (GRID * GRID);
      }
      EXPECT_NEAR(bySamples, byGrid, 0.012) << symmetry << " " << wi.x;
    }
  }
}

TEST(AdaptiveBrdf, SpectraBecomeTheColourOfTheirReflectance) {
  Tabulation t = roughMetal(Vec2f(0.6f), 16);
  t.brdf = [](const Vec3f&, const Vec3f&) { return 1 / M_PI; };
  t.wavelengths = {400, 450, 520, 580, 640, 700};
  t.colour = [](double w) { return 0.1 + 0.8 * std::clamp((w - 450) / 200, 0.0, 1.0); };
  SampledSpectrum spectrum;
  for (const float w : t.wavelengths) {
    spectrum.wavelengths.push_back(double(w));
    spectrum.values.push_back(t.colour(double(w)));
  }
  const Rgbd expected = rgbOfSpectrum(spectrum, SpectrumKind::ALBEDO);
  TensorFields fields = Tabulator(t).fields();
  const Vec3f a = glm::normalize(Vec3f(.3f, .1f, 1)), b = glm::normalize(Vec3f(-.2f, .4f, 1));
  const Rgbd found(AdaptiveBrdf(NAME, tensorFile(fields)).value(a, b));
  EXPECT_NEAR(found.r / found.g, expected.r / expected.g, 1e-4);
  EXPECT_NEAR(found.b / found.g, expected.b / expected.g, 1e-4);

  // A file with three values instead of spectra has the same colour.
  t.wavelengths = {0, 1, 2};
  t.colour = [&](double i) { return expected[int(i)]; };
  fields = Tabulator(t).fields();
  fields["rgb"] = fields["spectra"];
  fields.erase("spectra");
  fields.erase("wavelengths");
  const Rgbd rgb(AdaptiveBrdf(NAME, tensorFile(fields)).value(a, b));
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(rgb[k], found[k], 1e-4 * found[k]);
}

TEST(AdaptiveBrdf, CopperIsWhatItSays) {
  std::ifstream in("scenes/materials/copper.bsdf", std::ios::binary);
  const std::string stored{std::istreambuf_iterator<char>(in), {}}, made = adaptiveFile(copper());
  ASSERT_EQ(stored.size(), made.size());
  const AdaptiveBrdf a("stored", stored), b("made", made);
  TestRandom random(2);
  for (int i = 0; i < 1000; ++i) {
    const Vec3f wi = cosineHemisphere(random.next2()), wo = cosineHemisphere(random.next2());
    const Rgb expected = b.value(wi, wo);
    for (int k = 0; k < 3; ++k) ASSERT_NEAR(a.value(wi, wo)[k], expected[k], 1e-4f * (1 + expected[k]));
  }
}

TEST(AdaptiveBrdf, RefusesBrokenFiles) {
  const std::string good = adaptiveFile(roughMetal(Vec2f(0.5f), 4));
  EXPECT_EQ(complaint(good), "none");
  expectComplaint(complaint(""), "not a tensor file");
  for (const size_t length : {size_t(13), size_t(20), size_t(60), good.size() / 2, good.size() - 1})
    expectComplaint(complaint(good.substr(0, length)), "bytes, and the file has " + std::to_string(length));
  std::string bytes = good;
  bytes[12] = 2;
  expectComplaint(complaint(bytes), "version 2.0; 1.0 is read");
  for (const std::string name :
       {"theta_i", "phi_i", "ndf", "sigma", "vndf", "luminance", "spectra", "wavelengths", "jacobian"})
    expectComplaint(complaintAfter([&](TensorFields& f) { f.erase(name); }),
                    "there is no field \"" + name + "\"; there are: ");
  expectComplaint(complaintAfter([](TensorFields& f) {
                    f["vndf"].shape = {3, 1, 4, 4};
                  }),
                  "\"vndf\" is 3 x 1 x 4 x 4; it must be 1 x 3 x n x n");
  expectComplaint(complaintAfter([](TensorFields& f) { f["ndf"].shape = {16}; }),
                  "\"ndf\" is 16; it must be n x n");
  expectComplaint(complaintAfter([](TensorFields& f) {
                    f["vndf"].shape = {1, 3, 16, 1};
                  }),
                  "\"vndf\" needs 2 x 2 nodes");
  expectComplaint(complaintAfter([](TensorFields& f) { f["ndf"].type = 6; }),
                  "\"ndf\" is of type int32; float32 is read");
  expectComplaint(complaintAfter([](TensorFields& f) { f["ndf"].type = 12; }), "is of type 12");
  expectComplaint(complaintAfter([](TensorFields& f) {
                    f["sigma"].shape = {1ull << 63, 1ull << 63};
                  }),
                  "would be larger than the file");
}

TEST(AdaptiveBrdf, RefusesNumbersThatMeanNothing) {
  const auto withFloat = [](const std::string& name, size_t i, float value) {
    return complaintAfter(
        [&](TensorFields& f) { std::memcpy(&f[name].bytes[i * sizeof value], &value, sizeof value); });
  };
  for (const char* const name : {"theta_i", "ndf", "sigma", "vndf", "luminance", "spectra", "wavelengths"})
    for (const float value : {NAN, INFINITY})
      expectComplaint(withFloat(name, 1, value), std::string("a value of \"") + name + "\" is not finite");
  for (const char* const name : {"ndf", "sigma", "vndf"})
    expectComplaint(withFloat(name, 1, -1), std::string("\"") + name + "\" has a value below 0");
  EXPECT_EQ(withFloat("spectra", 1, -1e-3f), "none") << "noise of measurements";
  expectComplaint(withFloat("theta_i", 1, 0), "\"theta_i\" does not increase");
  expectComplaint(withFloat("theta_i", 2, 90), "\"theta_i\" is not between 0 and a right angle");
  Tabulation third = roughMetal(Vec2f(0.5f), 4);
  third.phis = {0, 1, 2.0944f};
  expectComplaint(complaint(adaptiveFile(third)), "\"phi_i\" goes from 0.000000 to 2.094400");
}

TEST(AdaptiveBrdf, ChangedBytesAreRefusedOrHarmless) {
  const std::string file = adaptiveFile(roughMetal(Vec2f(0.5f), 4));
  TestRandom random(23);
  int loaded = 0;
  for (int i = 0; i < 3000; ++i) {
    std::string bytes = file;
    for (uint32_t change = random.below(3) + 1; change > 0; --change) {
      // Most random changes are in the table of fields, where they are more dangerous than in the numbers.
      const uint32_t at = random.below(random.next() < 0.7f ? 500 : file.size());
      bytes[at] = static_cast<char>(random.next() < 0.5f ? bytes[at] ^ (1 << random.below(8))
                                                         : int(random.below(256)));
    }
    try {
      const AdaptiveBrdf brdf(NAME, bytes);
      ++loaded;
      for (int k = 0; k < 8; ++k) {
        const Vec3f a = cosineHemisphere(random.next2()), b = cosineHemisphere(random.next2());
        const float density = brdf.pdf(a, b);
        ASSERT_FALSE(std::isnan(density) || density < 0) << i;
        ASSERT_FALSE(std::isnan(brdf.value(a, b).g)) << i;
        if (const auto wo = brdf.sample(a, random.next2(), random.next())) {
          ASSERT_NEAR(glm::length(*wo), 1, 1e-4) << i;
        }
      }
    } catch (const Error& e) {
      ASSERT_EQ(std::string(e.what()).find(NAME), 0u) << e.what();
    }
  }
  EXPECT_GT(loaded, 100);
}
