/** @file
 * Convergence studies: variance and bias of known noise, fits and times of known curves, and the files.
 */
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include <nlohmann/json.hpp>
#include <unistd.h>

#include "recurse/core/io/error.h"
#include "recurse/report/converge/converge.h"
#include "report/noise.h"

using namespace recurse;

namespace {

Image constant(int width, int height, float value) {
  Image image(width, height, {"R", "G", "B"});
  std::fill(image.pixels.begin(), image.pixels.end(), value);
  return image;
}

/** Two noisy references around 1. */
References noisyReferences(int width, int height, unsigned seed) {
  const Image truth = constant(width, height, 1);
  return makeReferences({truth, noisy(truth, 0.2, seed), noisy(truth, 0.2, seed + 1)}, {"r", "a", "b"});
}

ConvergeCell cellOf(const std::string& run, const std::string& budget, uint64_t seed, double seconds,
                    double error) {
  ConvergeCell cell;
  cell.run = run;
  cell.budget = budget;
  cell.seed = seed;
  cell.seconds = seconds;
  cell.samplesPerPixel = 8 * seconds;
  cell.mse = cell.relMse = cell.relMseTrimmed = cell.mseNoiseFree = cell.relMseNoiseFree = error;
  cell.meanRatio = 1;
  return cell;
}

Study smallStudy() {
  Study study;
  study.identity = {{"content of the scene", "12"}, {"threads", "2"}};
  study.runs = {{"path", "path, maxdepth -1"}, {"pm", "photonmap, radius 0.1"}};
  study.budgets = {{1, "1s"}, {2, "2s"}};
  study.seeds = {5, 6};
  for (uint64_t seed : {5, 6}) {
    study.cells.push_back(cellOf("path", "1s", seed, 1, 0.1));
    study.cells.push_back(cellOf("path", "2s", seed, 2, 0.05));
  }
  study.cells.push_back(cellOf("pm", "1s", 5, 1.5, 0.02));
  return study;
}

class StudyFolder : public testing::Test {
 protected:
  void SetUp() override {
    folder =
        (std::filesystem::temp_directory_path() / ("recurse-converge-test-" + std::to_string(::getpid())))
            .string();
    std::filesystem::create_directories(folder + "/cells");
  }
  void TearDown() override { std::filesystem::remove_all(folder); }
  std::string folder;
};

} // namespace

TEST(Converge, VarianceAndBiasOfKnownNoise) {
  // Pictures are 0.1 too bright with noise of deviation 0.3; the references' noise must have no effect.
  constexpr int WIDTH = 128, HEIGHT = 96;
  const References references = noisyReferences(WIDTH, HEIGHT, 100);
  std::vector<Image> pictures;
  for (unsigned seed = 0; seed < 4; ++seed)
    pictures.push_back(noisy(constant(WIDTH, HEIGHT, 1.1f), 0.3, seed));
  const ErrorSplit split = splitError(pictures, references);
  EXPECT_NEAR(split.variance.value, 0.09, 0.002);
  EXPECT_NEAR(split.bias2.value, 0.01, 0.001);
  EXPECT_NEAR(split.relVariance.value, 0.09 / 1.01, 0.002);
  EXPECT_NEAR(split.relBias2.value, 0.01 / 1.01, 0.001);
  EXPECT_LT(split.bias2.low, 0.01);
  EXPECT_GT(split.bias2.high, 0.01);
  // Variance and squared bias add up to the error by definition, averaged over the seeds.
  double error = 0;
  for (const Image& picture : pictures) error += measureCell(picture, references).mseNoiseFree / 4;
  EXPECT_NEAR(split.variance.value + split.bias2.value, error, 1e-9);
  EXPECT_THROW(splitError({pictures[0]}, references), Error);
}

TEST(Converge, IntervalsHoldTheTruthAsOftenAsTheySay) {
  int held = 0, heldBlotchy = 0;
  constexpr int TRIALS = 200, SIZE = 48;
  const Image truth = constant(SIZE, SIZE, 1);
  for (unsigned trial = 0; trial < TRIALS; ++trial) {
    const References references = noisyReferences(SIZE, SIZE, 1000 + 2 * trial);
    const auto holds = [&](bool blotchy) {
      std::vector<Image> pictures;
      for (unsigned seed = 0; seed < 2; ++seed) {
        Image picture = noisy(constant(SIZE, SIZE, 1.05f), 0.2, 5000 + 2 * trial + seed);
        if (blotchy) // neighbours have a common error
          for (int y = 0; y < SIZE; ++y)
            for (int x = 0; x < SIZE; ++x)
              for (int c = 0; c < 3; ++c) picture.at(x, y)[c] = picture.at(x / 3 * 3, y / 3 * 3)[c];
        pictures.push_back(picture);
      }
      const Estimate bias2 = splitError(pictures, references).bias2;
      return bias2.low <= 0.0025 && bias2.high >= 0.0025;
    };
    held += holds(false);
    heldBlotchy += holds(true);
  }
  // The expectation is 190 of 200; 180 or less occur once in 500 times.
  EXPECT_GE(held, 180);
  EXPECT_LT(held, TRIALS);
  EXPECT_GE(heldBlotchy, 175);
}

TEST(Converge, BlockEstimateLeavesOutWhatIsNotANumber) {
  std::vector<double> values(40 * 20 * 3, 2.0);
  values[7] = std::numeric_limits<double>::quiet_NaN();
  const Estimate e = blockEstimate(values, 40, 20);
  EXPECT_DOUBLE_EQ(e.value, 2);
  EXPECT_DOUBLE_EQ(e.low, 2);
  std::fill(values.begin(), values.end(), std::numeric_limits<double>::quiet_NaN());
  EXPECT_TRUE(std::isnan(blockEstimate(values, 40, 20).value));
}

TEST(Converge, References) {
  const Image truth = constant(64, 48, 1), a = noisy(truth, 0.1, 1), b = noisy(truth, 0.1, 2);
  const References one = makeReferences({a}, {"one.exr"});
  EXPECT_FALSE(one.independent);
  EXPECT_NE(one.description.find("the errors and bias² include its own noise"), std::string::npos);
  EXPECT_TRUE(std::isnan(measureCell(truth, one).relMseNoiseFree));
  const References two = makeReferences({a, b}, {"a.exr", "b.exr"});
  EXPECT_TRUE(two.independent);
  EXPECT_FLOAT_EQ(two.r.at(3, 4)[1], (a.at(3, 4)[1] + b.at(3, 4)[1]) / 2);
  EXPECT_EQ(makeReferences({truth, a, b}, {"r", "a", "b"}).r.at(3, 4)[1], 1);
  EXPECT_NE(one.hash(), two.hash());
  // The mean of two with variance 0.01 each has a squared error of 0.005.
  const ReferenceError error = referenceError(a, b);
  EXPECT_NEAR(error.relMse.value, 0.005 / 1.01, 0.0003);
  EXPECT_LT(error.relMse.low, 0.005 / 1.01);
  EXPECT_GT(error.relMse.high, 0.005 / 1.01);
  EXPECT_EQ(error.text().find("worst"), std::string::npos);
  Image firefly = noisy(truth, 0.002, 3);
  const Image clean = noisy(truth, 0.002, 4);
  firefly.at(5, 5)[0] = 100;
  EXPECT_GT(referenceError(firefly, clean).worstShare, 0.9);
  EXPECT_NE(referenceError(firefly, clean).text().find("a few bright paths dominate"), std::string::npos);
  firefly.at(5, 5)[0] = std::numeric_limits<float>::infinity();
  EXPECT_THROW(makeReferences({firefly}, {"f.exr"}), Error);
  EXPECT_THROW(makeReferences({a, constant(3, 3, 1)}, {"a", "b"}), Error);
}

TEST(Converge, FitOfAPowerLaw) {
  Curve curve;
  for (double t : {1.0, 2.0, 4.0, 8.0}) curve.push_back({t, 0.3 * std::pow(t, -0.8)});
  std::optional<PowerLaw> fit = fitPowerLaw(curve);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->exponent, -0.8, 1e-12);
  EXPECT_NEAR(fit->factor, 0.3, 1e-12);
  EXPECT_NEAR(fit->standardError, 0, 1e-7);
  curve[1][1] *= 1.1;
  fit = fitPowerLaw(curve);
  EXPECT_GT(fit->standardError, 0.01);
  EXPECT_FALSE(fitPowerLaw({{1, 0.1}}));
  EXPECT_FALSE(fitPowerLaw({{1, 0.1}, {2, -0.1}})) << "what is not above zero has no logarithm";
  EXPECT_FALSE(fitPowerLaw({{1, 0.1}, {1.01, 0.05}})) << "one time is no range of times";
}

TEST(Converge, TimeToReach) {
  using Kind = TimeToReach::Kind;
  const Curve curve = {{1, 0.4}, {4, 0.1}, {16, 0.025}};
  EXPECT_EQ(timeToReach(curve, 0.5).kind, Kind::BEFORE);
  const TimeToReach between = timeToReach(curve, 0.05);
  EXPECT_EQ(between.kind, Kind::BETWEEN);
  EXPECT_NEAR(between.seconds, 8, 1e-9);
  EXPECT_NEAR(timeToReach(curve, 0.1).seconds, 4, 1e-9);
  const TimeToReach beyond = timeToReach(curve, 0.0125);
  EXPECT_EQ(beyond.kind, Kind::BEYOND);
  EXPECT_NEAR(beyond.seconds, 32, 1e-9);
  EXPECT_EQ(timeToReach(curve, 1e-4).kind, Kind::NEVER);
  EXPECT_EQ(timeToReach({{1, 0.4}, {2, 0.4}, {4, 0.4}}, 0.1).kind, Kind::NEVER) << "bias stays";
  EXPECT_EQ(timeToReach({}, 0.1).kind, Kind::NEVER);
  EXPECT_EQ(timeToReach({{1, 0.4}, {2, -0.001}}, 0.1).kind, Kind::BETWEEN);
  const std::vector<double> targets = targetErrors({curve, {{1, 0.7}}});
  ASSERT_EQ(targets.size(), 4u);
  EXPECT_NEAR(targets[0], 0.5, 1e-12);
  EXPECT_NEAR(targets[3], 0.05, 1e-12);
}

TEST_F(StudyFolder, JsonThereAndBack) {
  Study study = smallStudy();
  study.kind = BudgetKind::SAMPLES;
  study.cells[0].relMseNoiseFree = std::numeric_limits<double>::quiet_NaN();
  study.cells[1].nonFinite = 3;
  writeFileAtomically(folder + "/converge.json", studyJson(study));
  const Study back = readStudy(folder + "/converge.json");
  EXPECT_EQ(studyJson(back), studyJson(study));
  EXPECT_EQ(back.kind, BudgetKind::SAMPLES);
  EXPECT_TRUE(std::isnan(back.cells[0].relMseNoiseFree));
  EXPECT_EQ(back.cells[1].nonFinite, 3u);
  for (const char* broken : {"", "{}", "{\"format\": 99}", "[1, 2", "{\"format\": 1, \"kind\": \"other\"}"}) {
    writeFileAtomically(folder + "/converge.json", broken);
    EXPECT_THROW(readStudy(folder + "/converge.json"), Error) << broken;
  }
}

TEST(Converge, GoingOnNeedsTheSameStudy) {
  const Study study = smallStudy();
  Study more = study;
  more.runs.push_back({"new", "path, maxdepth 3"});
  more.budgets.push_back({0.5, "0.5s"});
  more.cells.clear();
  EXPECT_NO_THROW(requireSameStudy(study, more, "f"));
  more.include(study);
  EXPECT_EQ(more.cells.size(), study.cells.size());
  EXPECT_EQ(more.budgets.front().text, "0.5s");
  EXPECT_NE(more.find("path", "2s", 6), nullptr);
  EXPECT_EQ(more.find("new", "2s", 6), nullptr);
  const auto message = [&](const Study& wanted) {
    try {
      requireSameStudy(study, wanted, "folder");
      return std::string();
    } catch (const Error& error) {
      EXPECT_EQ(error.status(), ExitStatus::BAD_USAGE);
      return std::string(error.what());
    }
  };
  Study other = study;
  other.identity[0][1] = "13";
  EXPECT_NE(message(other).find("content of the scene: there 12, now 13"), std::string::npos);
  other = study;
  other.runs[1].settings = "photonmap, radius 0.2";
  EXPECT_NE(message(other).find("run pm: there photonmap, radius 0.1, now"), std::string::npos);
  other = study;
  other.kind = BudgetKind::PHOTONS;
  EXPECT_NE(message(other).find("budgets: there time, now photons"), std::string::npos);
}

TEST_F(StudyFolder, ReportOfAStudy) {
  const Study study = smallStudy();
  const References references = noisyReferences(16, 12, 9);
  for (const ConvergeCell& cell : study.cells)
    writeImage(folder + "/" + cellPictureName(cell.run, cell.budget, cell.seed),
               noisy(constant(16, 12, 1.1f), 0.1, static_cast<unsigned>(cell.seed)));
  StudyReport report = reportOf(study, references, folder);
  report.title = "it's <b>a</b> scene";
  ASSERT_EQ(report.points.size(), 3u);
  EXPECT_EQ(report.points[0].seeds, 2u);
  ASSERT_TRUE(report.points[0].split);
  EXPECT_NEAR(report.points[0].split->variance.value, 0.01, 0.002);
  EXPECT_FALSE(report.points[2].split) << "one seed has no variance";
  const ErrorMeasure measure = errorMeasures(report).front();
  EXPECT_STREQ(measure.key, "relmse_noise_free");
  EXPECT_EQ(curveOf(report, "path", measure), (Curve{{1, 0.1}, {2, 0.05}}));

  const std::string cells = cellsCsv(report), points = pointsCsv(report);
  EXPECT_EQ(std::count(cells.begin(), cells.end(), '\n'), 6);
  EXPECT_NE(cells.find("path,2s,6,2,16,"), std::string::npos) << cells;
  EXPECT_EQ(std::count(points.begin(), points.end(), '\n'), 4);
  EXPECT_NE(points.find("relbias2_low"), std::string::npos);
  const std::string table = studyTable(report);
  for (const char* part : {"path", "pm", "ε 0.01", "no trim", "(needs two seeds)", "t^-1", "time to"})
    EXPECT_NE(table.find(part), std::string::npos) << part << "\n" << table;

  const std::string script = plotScript(report);
  for (const char* part : {"set logscale xy", "it''s <b>a</b> scene", "t^-2/3", "path  t^-1"})
    EXPECT_NE(script.find(part), std::string::npos) << part << "\n" << script;

  const std::string page = convergePage(report, folder);
  EXPECT_EQ(page.find("<b>a</b>"), std::string::npos);
  const size_t begin = page.find("id=\"data\">") + 10;
  const nlohmann::json data =
      nlohmann::json::parse(page.substr(begin, page.find("</script>", begin) - begin));
  EXPECT_EQ(data["pictures"].size(), 4u); // the reference, and the first seed of each point
  EXPECT_EQ(data["measures"][0]["runs"][0]["curve"][1][1], 0.05);
  EXPECT_EQ(data["colours"].size(), 256u);
  EXPECT_EQ(data["measures"][0]["slopes"].size(), 2u);

  const std::string remark = writeReport(report, folder);
  EXPECT_EQ(remark.empty(), std::filesystem::exists(folder + "/plot.png")) << remark;
  EXPECT_FALSE(std::filesystem::exists(folder + "/.plot.png"));
  if (remark.empty()) {
    EXPECT_EQ(readImage(folder + "/plot.png").width, 1200);
  }
}

TEST_F(StudyFolder, OneReferenceAndErrorsBelowZero) {
  Study study = smallStudy();
  study.cells[0].relMse = study.cells[2].relMse = -1; // not drawn, and not an error
  const References references = makeReferences({constant(8, 8, 1)}, {"r.exr"});
  for (const ConvergeCell& cell : study.cells)
    writeImage(folder + "/" + cellPictureName(cell.run, cell.budget, cell.seed), constant(8, 8, 1));
  const StudyReport report = reportOf(study, references, folder);
  EXPECT_STREQ(errorMeasures(report).front().key, "relmse");
  EXPECT_NO_THROW(writeReport(report, folder));
  EXPECT_NE(studyTable(report).find("the errors and bias² include its own noise"), std::string::npos);
}
