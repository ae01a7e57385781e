/** @file
 * `recurse-mpi`: the same bits as one process, for any number of ranks, and for any killed rank.
 */
#ifdef RECURSE_MPI_PROGRAM

#include "program.h"

#include <cstdlib>
#include <random>

#include "recurse/core/image/image.h"
#include "sanitized.h"

using namespace programTesting;
using recurse::readImage;

namespace {

class Mpi : public Program {
 protected:
  void SetUp() override {
    Program::SetUp();
    if (recurse::testing::SANITIZED) GTEST_SKIP() << "what MPI itself leaks and hooks is not ours";
  }
  /** Exit status of a shell command in the folder, as root for mpirun; its output is in the file "log". */
  int shell(const std::string& command) const {
    const int status = std::system(("cd " + folder +
                                    " && export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1"
                                    " ASAN_OPTIONS=detect_leaks=0 && { " +
                                    command + "; } >log 2>&1")
                                       .c_str());
    return WEXITSTATUS(status);
  }
  static std::string ranks(int count, const std::string& program = RECURSE_MPI_PROGRAM) {
    // Open MPI 4.1 may wait for ever for a rank that is killed during its start.
    return "timeout -k 1 60 " RECURSE_MPIRUN " --oversubscribe --mca plm ^rsh -n " + std::to_string(count) +
           " " + program + " ";
  }
  std::string log() const { return contents(file("log")); }
  std::vector<float> whole(const std::string& settings) const {
    EXPECT_EQ(shell(RECURSE_PROGRAM " render scene.pbrt -q -o whole.exr" + settings), 0) << log();
    return readImage(file("whole.exr")).pixels;
  }
  /** Runs with a different number of ranks each time, and kills a random rank. */
  void killAndGoOn(const std::string& settings, std::mt19937& random) const {
    const std::vector<float> truth = whole(settings);
    int kills = 0;
    std::filesystem::remove(file("c.rck"));
    for (int round = 0; round < 4; ++round) {
      const std::string seconds = std::to_string(0.6 + 0.1 * double(random() % 10));
      const int status = shell(ranks(2 + round % 2) +
                               "render scene.pbrt -q --checkpoint c.rck --checkpoint-interval 0.05s --resume "
                               "-o r.exr" +
                               settings + " & run=$!; sleep " + seconds +
                               "; kill -9 $(pgrep -P $(pgrep -P $run) | shuf -n 1); wait $run");
      kills += status != 0;
      if (status != 0 && kills == 1) {
        EXPECT_TRUE(has(log(), "noticed that process rank")) << log();
      }
    }
    ASSERT_EQ(shell(ranks(2) + "render scene.pbrt -q --checkpoint c.rck --resume -o r.exr" + settings), 0)
        << log();
    EXPECT_TRUE(readImage(file("r.exr")).pixels == truth) << kills << " kills," << settings;
  }
};

} // namespace

TEST_F(Mpi, AnyNumberOfRanksMakesTheSamePicture) {
  for (const std::string settings :
       {" --integrator path --spp 40", " --integrator sppm --photons 1000 --spp 9",
        " --integrator photonmap --photons 5000 --spp 6", " --integrator bdpt --spp 7",
        " --integrator photonmap --photons 300000 --spp 2 --time-of-flight 2:6:4",
        " --integrator bdpt --spp 3 --time-of-flight 2:6:4", " --integrator path --adaptive --spp 40",
        " --integrator sppm --photons 1000 --adaptive --spp 20"}) {
    const std::vector<float> truth = whole(settings);
    const int most = settings.find("path") != std::string::npos ? 3 : 2;
    for (int n = most == 3 ? 1 : 2; n <= most; ++n) {
      ASSERT_EQ(shell(ranks(n) + "render scene.pbrt -q -o r.exr" + settings), 0) << log();
      EXPECT_TRUE(readImage(file("r.exr")).pixels == truth) << n << " ranks" << settings;
      std::filesystem::remove(file("r.exr"));
    }
  }
}

TEST_F(Mpi, OneMapIsShotByAllTogether) {
  write("scene.pbrt", "Integrator \"photonmap\" \"integer passes\" 1\n" + scene());
  const std::string settings = " --photons 300000 --spp 1";
  const std::vector<float> truth = whole(settings);
  ASSERT_EQ(shell(ranks(2) + "render scene.pbrt -q -o r.exr --stats s.json" + settings), 0) << log();
  EXPECT_TRUE(readImage(file("r.exr")).pixels == truth);
  EXPECT_TRUE(has(contents(file("s.json")), "\"photons_emitted\": 300000,")) << contents(file("s.json"));
}

TEST_F(Mpi, KilledRanksCostNothingButTime) {
  std::mt19937 random(7);
  for (const std::string settings :
       {" --integrator sppm --photons 4000 --spp 150", " --integrator path --adaptive --spp 1500"})
    killAndGoOn(settings, random);
}

TEST_F(Mpi, ARankThatDoesNotAnswerIsNamed) {
  write("await.sh", "for i in $(seq 1200); do grep -q \"$1\" log && break; sleep 0.05; done\n");
  // mpirun passes SIGUSR1 on to all ranks.
  EXPECT_EQ(shell(ranks(2) +
                  "render scene.pbrt --integrator path --spp 1000000000 -o r.exr --progress json & "
                  "run=$!; sh await.sh '\"picture\"'; "
                  "stopped=$(pgrep -P $(pgrep -P $run) | tail -n 1); kill -STOP $stopped; "
                  "sh await.sh 'waiting for'; kill -CONT $stopped; "
                  "sh await.sh 'answers again'; kill -USR1 $(pgrep -P $run); wait $run"),
            130)
      << log();
  EXPECT_TRUE(has(log(), "waiting for rank 1 on ")) << log();
  EXPECT_TRUE(has(log(), "answers again")) << log();
  EXPECT_TRUE(exists("r.exr"));
}

TEST_F(Mpi, WhoHasAnotherSceneIsNamed) {
  write("other.pbrt", scene() + "\n# another word\n");
  write("rank.sh", "#!/bin/sh\nscene=scene.pbrt\n[ $OMPI_COMM_WORLD_RANK = 1 ] && scene=$OTHER\n"
                   "exec " RECURSE_MPI_PROGRAM " render $scene --spp 1 -q -o r.exr\n");
  EXPECT_EQ(shell("OTHER=other.pbrt " + ranks(2, "sh rank.sh")), 1);
  EXPECT_TRUE(has(log(), "rank 1 on ") && has(log(), "scene files (hash)")) << log();
  EXPECT_EQ(shell("OTHER=none.pbrt " + ranks(2, "sh rank.sh")), 1);
  EXPECT_TRUE(has(log(), "rank 1 on ") && has(log(), "cannot read none.pbrt")) << log();
  EXPECT_FALSE(exists("r.exr"));
}

TEST_F(Mpi, RanksWithoutTheFilesGetThem) {
  std::filesystem::create_directories(file("parts/meshes"));
  write("parts/floor.pbrt", "Shape \"plymesh\" \"string filename\" \"meshes/../meshes/a.ply\"\n");
  write("parts/meshes/a.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 .2 0\n1 .2 0\n0 .2 1\n3 0 1 2\n");
  write("scene.pbrt", scene("", "Include \"parts/floor.pbrt\"\n"));
  const std::vector<float> truth = whole(" --integrator path --spp 8");
  // The file is missing for rank 1.
  write("rank.sh",
        "#!/bin/sh\n[ $OMPI_COMM_WORLD_RANK = 1 ] && cd /\n"
        "exec " RECURSE_MPI_PROGRAM " render ${1:-scene.pbrt} --integrator path --spp 8 --send-scene -q "
        "-o r.exr $SIZE\n");
  ASSERT_EQ(shell(ranks(2, "sh rank.sh")), 0) << log();
  EXPECT_TRUE(readImage(file("r.exr")).pixels == truth);
  write("model.obj",
        "mtllib model.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl red\nf 1/1 2/2 3/3\n");
  write("model.mtl", "newmtl red\nKd 1 1 1\nmap_Kd skin.ppm\n");
  write("skin.ppm", "P3 2 1 255 250 20 20 20 250 20\n");
  for (const char* name : {"model.obj", "models.pbrt"}) {
    write("models.pbrt", scene("", "Shape \"mesh\" \"string filename\" \"model.obj\"\n"));
    ASSERT_EQ(shell(RECURSE_PROGRAM " render " + std::string(name) +
                    " --integrator path --spp 8 --resolution 40x30 -q -o one.exr"),
              0);
    ASSERT_EQ(shell("SIZE='--resolution 40x30' " + ranks(2, "sh rank.sh") + name), 0) << log();
    EXPECT_TRUE(readImage(file("r.exr")).pixels == readImage(file("one.exr")).pixels) << name;
  }
  EXPECT_EQ(shell(ranks(2, "sh rank.sh") + "none.pbrt"), 1);
  EXPECT_TRUE(has(log(), "cannot read none.pbrt")) << log();
}

TEST_F(Mpi, LimitsHold) {
  ASSERT_EQ(shell(ranks(2) + "render scene.pbrt --integrator path --time-limit 0.5s -o r.exr --stats s.json"),
            0)
      << log();
  EXPECT_TRUE(has(contents(file("s.json")), "\"stop_reason\": \"time\"")) << log();
  ASSERT_EQ(
      shell(ranks(2) + "render scene.pbrt --integrator path --error-target 0.1 -o r.exr --stats s.json"), 0)
      << log();
  EXPECT_TRUE(has(contents(file("s.json")), "\"stop_reason\": \"error\"")) << log();
}

TEST_F(Mpi, TimeLimitEndsTheFirstPassOfPhotons) {
  // Number of photons that takes more time than the test allows.
  for (const std::string passes : {"1", "0"}) {
    ASSERT_EQ(shell(ranks(2) +
                    "render scene.pbrt --integrator photonmap --set photons=2000000000 --set passes=" +
                    passes + " --time-limit 0.5s -o r.exr --stats s.json"),
              0)
        << log();
    EXPECT_TRUE(has(contents(file("s.json")), "\"stop_reason\": \"time\"")) << log();
    EXPECT_TRUE(has(log(), "before photonmap had one sample of every pixel")) << log();
  }
}

#endif
