/** @file
 * Memory limits of control groups, in synthetic hierarchies.
 */
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include <unistd.h>

#include "core/threads/controlGroup.h"

using namespace recurse;

namespace {

class ControlGroup : public ::testing::Test {
 protected:
  ControlGroup()
      : root(std::filesystem::temp_directory_path() / ("recurse-groups-" + std::to_string(::getpid()))) {}
  ~ControlGroup() override { std::filesystem::remove_all(root); }
  void write(const std::string& file, const std::string& text) const {
    std::filesystem::create_directories((root / file).parent_path());
    std::ofstream(root / file) << text << "\n";
  }
  double left() const {
    return detail::memoryLeftByGroups((root / "self").string(), (root / "mount").string());
  }

 private:
  const std::filesystem::path root;
};

} // namespace

TEST_F(ControlGroup, WithoutLimitsLeaveEverything) {
  EXPECT_EQ(left(), INFINITY);
  write("self", "0::/");
  EXPECT_EQ(left(), INFINITY);
  write("mount/memory.max", "max");
  write("mount/memory.current", "5000");
  EXPECT_EQ(left(), INFINITY);
}

TEST_F(ControlGroup, LeaveTheirLimitWithoutWhatIsInUse) {
  write("self", "0::/");
  write("mount/memory.max", "9000");
  write("mount/memory.current", "5000");
  EXPECT_EQ(left(), 4000);
  write("mount/memory.stat", "anon 2000\nfile 3000\ninactive_file 1500\nactive_file 1500");
  EXPECT_EQ(left(), 7000);
  write("mount/memory.current", "12000");
  EXPECT_EQ(left(), 0);
}

TEST_F(ControlGroup, AllThatContainTheProcessCount) {
  write("self", "0::/user/a b:c/job");
  write("mount/memory.max", "90000");
  write("mount/memory.current", "10000");
  EXPECT_EQ(left(), 80000); // also if deeper groups are not visible
  write("mount/user/memory.max", "60000");
  write("mount/user/memory.current", "50000");
  write("mount/user/a b:c/job/memory.max", "20000");
  write("mount/user/a b:c/job/memory.current", "5000");
  EXPECT_EQ(left(), 10000);
  write("mount/user/memory.max", "max");
  EXPECT_EQ(left(), 15000);
}

TEST_F(ControlGroup, OfVersion1AreInAFolderOfTheirOwn) {
  write("self", "5:pids:/other\n4:cpu,memory:/job\n1:name=systemd:/other");
  write("mount/memory/memory.limit_in_bytes", "9223372036854771712");
  write("mount/memory/job/memory.limit_in_bytes", "7000");
  write("mount/memory/job/memory.usage_in_bytes", "4000");
  write("mount/memory/job/memory.stat", "inactive_file 10\ntotal_inactive_file 500\ntotal_active_file 100");
  EXPECT_EQ(left(), 3600);
}
