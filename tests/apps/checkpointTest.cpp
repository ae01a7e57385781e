/** @file
 * `recurse render --checkpoint --resume --sample-range` and `recurse merge`: the picture has the same bits
 * for any interruption and any partition of a render.
 */
#include "program.h"

#include <cstdlib>
#include <random>

#include "recurse/core/image/image.h"
#include "recurse/core/io/error.h"
#include "recurse/core/io/fileLock.h"
#include "recurse/render/checkpoint.h"
#include "sanitized.h"

using namespace programTesting;
using recurse::readImage;

namespace {

class Checkpoints : public Program {
 protected:
  /** Picture of an uninterrupted render; `seconds`: its duration. */
  std::vector<float> whole(const std::vector<std::string>& settings, double* seconds = nullptr) {
    const Outcome o = render(settings, {"-o", "whole.exr"});
    EXPECT_EQ(o.status, 0) << o.err;
    if (seconds) *seconds = o.seconds;
    return readImage(file("whole.exr")).pixels;
  }
  Outcome render(std::vector<std::string> settings, const std::vector<std::string>& more,
                 const std::function<void(pid_t)>& meanwhile = {}) {
    settings.insert(settings.begin(), {"render", "scene.pbrt", "-q"});
    settings.insert(settings.end(), more.begin(), more.end());
    return run(settings, meanwhile);
  }
  void expectError(const Outcome& o, const std::string& text) {
    EXPECT_NE(o.status, 0);
    EXPECT_LT(o.status, 128) << "killed";
    EXPECT_TRUE(has(o.err, text)) << o.err;
  }
};

const std::vector<std::string> PATH = {"--integrator", "path", "--spp", "64"};
/** Light paths splat to all pixels. */
const std::vector<std::string> BDPT = {"--integrator", "bdpt", "--spp", "24"};
const std::vector<std::string> SPPM = {"--integrator", "sppm", "--spp", "24", "--photons", "2000"};

std::vector<std::string> adaptive(std::vector<std::string> settings) {
  settings.emplace_back("--adaptive");
  return settings;
}

} // namespace

TEST_F(Checkpoints, KilledAgainAndAgainAndStillTheSame) {
  const int wanted = recurse::testing::samples(50);
  std::mt19937 random(3);
  int kills = 0;
  const std::vector<std::vector<std::string>> all = {PATH, adaptive(SPPM), BDPT, adaptive(PATH), SPPM};
  for (int round = 0; kills < wanted || round < int(all.size()); ++round) {
    ASSERT_LT(round, 40) << "renders end before they are killed";
    const std::vector<std::string>& settings = all[size_t(round) % all.size()];
    double seconds = 0;
    const std::vector<float> truth = whole(settings, &seconds);
    std::filesystem::remove(file("c.rck"));
    // The first runs are too short for any progress; the length increases until a run is completed.
    for (double longest = 0.1 * seconds;; longest *= 1.25) {
      const double delay = std::uniform_real_distribution<>(0, longest)(random);
      const Outcome o = render(
          settings, {"--checkpoint", "c.rck", "--checkpoint-interval", "0.005s", "--resume", "-o", "r.exr"},
          [&](pid_t child) {
            sleepSeconds(delay);
            ::kill(child, SIGKILL);
          });
      if (o.status == 0) break;
      ASSERT_EQ(o.status, 128 + SIGKILL) << o.err;
      ++kills;
    }
    ASSERT_TRUE(readImage(file("r.exr")).pixels == truth)
        << "round " << round << " after " << kills << " kills";
  }
}

TEST_F(Checkpoints, InterruptedRendersGoOn) {
  const std::vector<std::string> settings = {"--integrator", "path", "--spp",
                                             std::to_string(recurse::testing::samples(3000))};
  const std::vector<float> truth = whole(settings);
  const std::vector<std::string> kept = {"--checkpoint", "c.rck", "--resume", "-o", "r.exr"};
  std::vector<std::string> watched = {"render", "scene.pbrt", "--progress", "json"};
  watched.insert(watched.end(), settings.begin(), settings.end());
  watched.insert(watched.end(), kept.begin(), kept.end());
  const Outcome interrupted = run(watched, onceUnderWay(SIGINT));
  ASSERT_EQ(interrupted.status, 130) << interrupted.err;
  EXPECT_TRUE(std::filesystem::exists(file("c.rck")));
  const Outcome o = render(settings, kept);
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_TRUE(readImage(file("r.exr")).pixels == truth);
  // A complete render has nothing left to do.
  ASSERT_EQ(render(settings, kept).status, 0);
  EXPECT_TRUE(readImage(file("r.exr")).pixels == truth);
}

TEST_F(Checkpoints, PartsAddUpToTheWhole) {
  for (const std::vector<std::string>& settings : {PATH, SPPM, BDPT}) {
    const std::vector<float> truth = whole(settings);
    const std::string last = settings[3];
    for (const auto& [name, range] : std::vector<std::pair<std::string, std::string>>{
             {"a.rck", "0:5"}, {"b.rck", "5:16"}, {"c.rck", "16:" + last}}) {
      std::filesystem::remove(file(name));
      const Outcome o = render(settings, {"--sample-range", range, "--checkpoint", name, "-o", "part.exr"});
      ASSERT_EQ(o.status, 0) << o.err;
    }
    ASSERT_EQ(run({"merge", "c.rck", "a.rck", "--checkpoint", "ca.rck"}).status, 0);
    const Outcome o = run({"merge", "ca.rck", "b.rck", "-o", "sum.exr", "-o", "sum.png"});
    ASSERT_EQ(o.status, 0) << o.err;
    const recurse::Image sum = readImage(file("sum.exr"));
    EXPECT_EQ(sum.metadata.at("recurse:samples"), last);
    ASSERT_TRUE(sum.pixels == truth);
    expectError(run({"merge", "ca.rck", "a.rck", "-o", "x.exr"}), "would be counted twice");
  }
}

TEST_F(Checkpoints, SplitJobsMakeTheSamePicture) {
  for (const std::vector<std::string>& settings : {PATH, SPPM, BDPT}) {
    const std::vector<float> truth = whole(settings);
    std::filesystem::remove_all(file("job"));
    std::vector<std::string> split = {"split", "scene.pbrt", "--parts", "3", "-o", "job"};
    split.insert(split.end(), settings.begin(), settings.end());
    const Outcome o = run(split);
    ASSERT_EQ(o.status, 0) << o.err;
    const auto shell = [&](const std::string& command) {
      return std::system(
          ("cd " + folder + " && export RECURSE=" RECURSE_PROGRAM " && " + command + " 2>log").c_str());
    };
    ASSERT_EQ(shell("job/local.sh"), 0) << contents(file("log"));
    EXPECT_TRUE(readImage(file("job/picture.exr")).pixels == truth);

    // Missing and incomplete parts are named, and rendered again.
    std::filesystem::remove(file("job/picture.exr"));
    std::filesystem::remove(file("job/part-001.rck"));
    EXPECT_NE(shell("job/merge.sh"), 0);
    const std::string said = contents(file("log"));
    const std::string middle = settings[3] == "64" ? "21:42" : "8:16";
    EXPECT_TRUE(has(said, "part-001.rck: no such file") && has(said, "samples " + middle)) << said;
    EXPECT_FALSE(exists("job/picture.exr"));
    ASSERT_EQ(shell("job/merge.sh --partial"), 0) << contents(file("log"));
    EXPECT_FALSE(readImage(file("job/picture.exr")).pixels == truth);
    ASSERT_EQ(shell("SLURM_ARRAY_TASK_ID=1 job/slurm.sh && job/merge.sh"), 0) << contents(file("log"));
    EXPECT_TRUE(readImage(file("job/picture.exr")).pixels == truth);
  }
  expectError(run({"split", "scene.pbrt", "--parts", "3", "-o", "job"}), "--spp");
  expectError(run({"split", "scene.pbrt", "--parts", "3", "-o", "job", "--spp", "2"}), "--parts");
  expectError(run({"split", "scene.pbrt", "--parts", "3", "-o", "job", "--spp", "8", "--adaptive"}),
              "--adaptive");
}

TEST_F(Checkpoints, ASplitJobWorksInTheFolderWhereItIs) {
  ASSERT_EQ(
      run({"split", "scene.pbrt", "--parts", "2", "-o", "job", "--spp", "2", "--integrator", "path"}).status,
      0);
  std::filesystem::copy(file("job"), file("copy of it"));
  const auto shell = [&](const std::string& command) {
    return std::system(
        ("cd " + folder + " && export RECURSE=" RECURSE_PROGRAM " && " + command + " 2>log").c_str());
  };
  ASSERT_EQ(shell("'copy of it/local.sh'"), 0) << contents(file("log"));
  EXPECT_TRUE(exists("copy of it/picture.exr"));
  EXPECT_FALSE(exists("job/part-000.rck") || exists("job/picture.exr"));
  // Slurm runs a copy of the submitted script.
  std::filesystem::remove(file("copy of it/part-001.rck"));
  std::filesystem::create_directories(file("spool"));
  std::filesystem::copy(file("copy of it/slurm.sh"), file("spool/slurm_script"));
  write("spool/scontrol",
        "#!/bin/sh\necho 'JobId='$3\necho '   Command=" + folder + "/copy of it/slurm.sh'\n");
  std::filesystem::permissions(file("spool/scontrol"), std::filesystem::perms::owner_all);
  ASSERT_EQ(shell("PATH=$PWD/spool:$PATH SLURM_JOB_ID=8 SLURM_ARRAY_JOB_ID=7 SLURM_ARRAY_TASK_ID=1 "
                  "spool/slurm_script"),
            0)
      << contents(file("log"));
  EXPECT_TRUE(exists("copy of it/part-001.rck") && exists("copy of it/slurm-7_1.log"));
  EXPECT_FALSE(exists("job/part-001.rck"));
}

TEST_F(Checkpoints, APictureOfWhatIsUnfinishedIsAskedFor) {
  const Outcome o = run({"render", "scene.pbrt", "--progress", "json", "--integrator", "path", "--spp",
                         "1000000", "--checkpoint", "c.rck", "-o", "r.exr"},
                        onceUnderWay(SIGINT));
  ASSERT_EQ(o.status, 130) << o.err;
  expectError(run({"merge", "c.rck", "-o", "x.exr"}), "--partial");
  EXPECT_FALSE(exists("x.exr"));
  ASSERT_EQ(run({"merge", "c.rck", "-o", "x.exr", "--partial"}).status, 0);
  EXPECT_TRUE(readImage(file("x.exr")).pixels == readImage(file("r.exr")).pixels);
}

TEST_F(Checkpoints, OtherSeedsAddUp) {
  for (const char* seed : {"1", "2"})
    ASSERT_EQ(render(PATH, {"--seed", seed, "--checkpoint", std::string(seed) + ".rck", "-o",
                            std::string(seed) + ".exr"})
                  .status,
              0);
  ASSERT_EQ(run({"merge", "1.rck", "2.rck", "-o", "sum.exr"}).status, 0);
  const auto a = readImage(file("1.exr")).pixels, b = readImage(file("2.exr")).pixels,
             sum = readImage(file("sum.exr")).pixels;
  double difference = 0;
  for (size_t i = 0; i < sum.size(); ++i) {
    EXPECT_NEAR(sum[i], (a[i] + b[i]) / 2, 1e-5f * (a[i] + b[i])); // box filter: all weights are one
    difference += std::abs(double(a[i]) - double(b[i]));
  }
  EXPECT_GT(difference, 0);
}

TEST_F(Checkpoints, AdaptiveSeedsAddUpByTheirSamples) {
  for (const char* seed : {"1", "2"}) {
    const Outcome o = render(adaptive(PATH), {"--seed", seed, "--checkpoint", std::string(seed) + ".rck",
                                              "-o", std::string(seed) + ".exr", "--samples-layer"});
    ASSERT_EQ(o.status, 0) << o.err;
  }
  ASSERT_EQ(
      run({"merge", "1.rck", "2.rck", "-o", "sum.exr", "--samples-layer", "--checkpoint", "s.rck"}).status,
      0);
  ASSERT_EQ(run({"merge", "s.rck", "-o", "again.exr", "--samples-layer"}).status, 0);
  const recurse::Image a = readImage(file("1.exr")), b = readImage(file("2.exr")),
                       sum = readImage(file("sum.exr"));
  ASSERT_EQ(sum.channels.back(), "samples.N");
  EXPECT_TRUE(readImage(file("again.exr")).pixels == sum.pixels);
  float least = 1e9f, most = 0;
  for (size_t i = 0; i < sum.pixels.size(); i += 4) {
    const float n = a.pixels[i + 3], m = b.pixels[i + 3];
    ASSERT_EQ(sum.pixels[i + 3], n + m);
    for (size_t c = 0; c < 3; ++c) {
      const float expected = (n * a.pixels[i + c] + m * b.pixels[i + c]) / (n + m); // a box filter
      ASSERT_NEAR(sum.pixels[i + c], expected, 1e-5f * expected);
    }
    least = std::min({least, n, m});
    most = std::max({most, n, m});
  }
  EXPECT_GE(least, 64 / 4);
  EXPECT_GT(most, least);
}

TEST_F(Checkpoints, WhatDoesNotFitIsRefusedWithTheReason) {
  ASSERT_EQ(render(PATH, {"--checkpoint", "c.rck", "-o", "a.exr"}).status, 0);
  expectError(render(PATH, {"--checkpoint", "c.rck", "-o", "a.exr"}), "--resume");
  const std::vector<std::string> resume = {"--checkpoint", "c.rck", "--resume", "-o", "a.exr"};
  const auto resumed = [&](const std::vector<std::string>& settings) { return render(settings, resume); };
  expectError(resumed({"--integrator", "path", "--spp", "65"}),
              "samples per pixel: 64 in the checkpoint, 65");
  expectError(resumed({"--integrator", "path", "--spp", "64", "--maxdepth", "3"}), "integrator:");
  expectError(resumed({"--integrator", "path", "--spp", "64", "--resolution", "30x20"}), "resolution:");
  expectError(resumed({"--integrator", "path", "--spp", "64", "--cropwindow", "0,.5,0,1"}),
              "part of the picture");
  expectError(resumed({"--integrator", "path", "--spp", "64", "--paths", "LDE"}), "path classes:");
  expectError(resumed({"--integrator", "path", "--spp", "64", "--seed", "8"}), "seed 8");
  expectError(resumed(adaptive(PATH)), "sample distribution: uniform in the checkpoint, adaptive");
  write("scene.pbrt", scene() + "\n# another word\n");
  expectError(resumed(PATH), "scene files");
  write("scene.pbrt", scene());
  EXPECT_EQ(resumed(PATH).status, 0);

  const std::string good = contents(file("c.rck"));
  const auto expectRefused = [&](const std::string& bad) {
    write("bad.rck", bad);
    try {
      recurse::Checkpoint::read(file("bad.rck"));
      ADD_FAILURE() << bad.size() << " bytes were taken";
    } catch (const recurse::Error& error) {
      EXPECT_TRUE(has(error.what(), "bad.rck: ")) << error.what();
    }
  };
  for (const size_t size : {size_t(0), size_t(10), size_t(25), size_t(300), good.size() / 2, good.size() - 1})
    expectRefused(good.substr(0, size));
  for (const size_t place : {size_t(3), size_t(23), size_t(200), good.size() / 2, good.size() - 3}) {
    std::string damaged = good;
    damaged[place] = static_cast<char>(damaged[place] ^ 0x55);
    expectRefused(damaged);
  }
  expectError(run({"merge", "bad.rck", "-o", "x.exr"}), "bad.rck: ");
  expectError(run({"merge", "none.rck", "-o", "x.exr"}), "none.rck: ");
  expectError(run({"merge", "c.rck"}), "no output");
  EXPECT_FALSE(std::filesystem::exists(file("x.exr")));
  for (const char* range : {"5", "5:5", "-1:5", "0:65", "a:b", ""})
    expectError(render(PATH, {"--sample-range", range}), "--sample-range");
  expectError(render({"--integrator", "path"}, {"--sample-range", "0:4"}), "--spp");
  expectError(render(adaptive(PATH), {"--sample-range", "0:4"}), "--adaptive");
  expectError(render(PATH, {"--resume"}), "--checkpoint");
}

TEST_F(Checkpoints, KeepAllCounts) {
  using recurse::PixelBounds;
  recurse::TransportCounts counts;
  counts.rays = 101;
  counts.boundaryRays = 102;
  counts.nonFinite = 103;
  counts.truncatedThroughput = 104;
  counts.gathers = 105;
  counts.photonsFound = 106;
  counts.photonsScattered = 107;
  recurse::Checkpoint written{
      {}, {}, 1, {{"all", "all"}}, {{0, 0, 1}}, {}, recurse::Film(PixelBounds{0, 0, 2, 2}, 1), {}};
  written.position.statistics.counts = counts;
  recurse::writeCheckpoint(file("counts.rck"), written);
  const recurse::TransportCounts read =
      recurse::Checkpoint::read(file("counts.rck")).position.statistics.counts;
  EXPECT_EQ(read.rays, counts.rays);
  EXPECT_EQ(read.boundaryRays, counts.boundaryRays);
  EXPECT_EQ(read.nonFinite, counts.nonFinite);
  EXPECT_EQ(read.truncatedThroughput, counts.truncatedThroughput);
  EXPECT_EQ(read.gathers, counts.gathers);
  EXPECT_EQ(read.photonsFound, counts.photonsFound);
  EXPECT_EQ(read.photonsScattered, counts.photonsScattered);
}

TEST_F(Checkpoints, OneProcessAtATime) {
  const std::vector<std::string> more = {"-o", "a.exr", "--checkpoint", "c.rck", "--resume"};
  {
    const recurse::FileLock held(file("c.rck"));
    EXPECT_TRUE(exists("c.rck.lock"));
    expectError(render(PATH, more), "another process uses it");
    EXPECT_FALSE(exists("a.exr"));
  }
  EXPECT_FALSE(exists("c.rck.lock"));
  const Outcome o = render(PATH, more);
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_TRUE(exists("c.rck"));
  EXPECT_FALSE(exists("c.rck.lock"));
}
