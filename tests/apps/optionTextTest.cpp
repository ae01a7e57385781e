/** @file
 * Values of options: accepted and rejected texts.
 */
#include <gtest/gtest.h>

#include "apps/options/optionText.h"
#include "recurse/core/io/error.h"

using namespace recurse;
using namespace recurse::apps;

TEST(OptionText, Durations) {
  const std::vector<std::pair<const char*, double>> good = {{"30s", 30},      {"2m", 120},    {"1h30m", 5400},
                                                            {"1h2m3s", 3723}, {"90", 90},     {"1.5h", 5400},
                                                            {"500ms", 0.5},   {"0.25s", 0.25}};
  for (const auto& [text, seconds] : good) EXPECT_DOUBLE_EQ(parseDuration("-t", text), seconds) << text;
  for (const char* bad :
       {"", "s", "0", "-3s", "3s2m", "3x", "3 s", "1m1m", "nan", "inf", "1e400s", "3m4", "--", "."})
    EXPECT_THROW(parseDuration("-t", bad), Error) << bad;
}

TEST(OptionText, Sizes) {
  EXPECT_EQ(parseResolution("-r", "640x480"), (std::array{640, 480}));
  for (const char* bad : {"", "x", "640", "640x", "x480", "0x5", "5x0", "-1x5", "6.5x4", "1x2x3", "70000x1",
                          "a4x5", "640X480", "99999999999999x1"})
    EXPECT_THROW(parseResolution("-r", bad), Error) << bad;
  EXPECT_EQ(parseCropWindow("-c", "0,0.5,.25,1"), (std::array{0.0, 0.5, 0.25, 1.0}));
  for (const char* bad : {"", "0,1,0", "0,1,0,1,0", "0,1,0,x", "1,0,0,1", "0,1,0.5,0.5", "0,2,0,1",
                          "-1,1,0,1", "0,1,,1", "nan,1,0,1"})
    EXPECT_THROW(parseCropWindow("-c", bad), Error) << bad;
}

TEST(OptionText, Numbers) {
  for (const char* million : {"1000000", "1e6", "1M", "1000k", "+1M", "0.001G"})
    EXPECT_EQ(parseCount("-n", million, 1, 2000000), 1000000) << million;
  EXPECT_EQ(parseCount("-n", "-1", -1, 5), -1);
  for (const char* bad : {"", "0", "6", "2.5", "1x", "x", "0x3", "k", "1e999", "nan", " 1", "1 "})
    EXPECT_THROW(parseCount("-n", bad, 1, 5), Error) << bad;
  EXPECT_EQ(parseSeed("-s", "18446744073709551615"), 18446744073709551615ull);
  for (const char* bad : {"", "-1", "18446744073709551616", "1.0", "a"})
    EXPECT_THROW(parseSeed("-s", bad), Error);
  EXPECT_DOUBLE_EQ(parseReal("-x", "-1.5e3"), -1500);
  for (const char* bad : {"", "1,5", "inf", "nan", "one"}) EXPECT_THROW(parseReal("-x", bad), Error) << bad;
  try {
    parseReal("--radius", "wide");
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "--radius: 'wide' is not a number");
    EXPECT_EQ(error.status(), ExitStatus::BAD_USAGE);
  }
}

TEST(OptionText, Printing) {
  EXPECT_EQ(durationText(1.234), "1.23s");
  EXPECT_EQ(durationText(12.34), "12.3s");
  EXPECT_EQ(durationText(187), "3m07s");
  EXPECT_EQ(durationText(7500), "2h05m");
  EXPECT_EQ(countText(0), "0");
  EXPECT_EQ(countText(9999), "9999");
  EXPECT_EQ(countText(747000), "747k");
  EXPECT_EQ(countText(1e6), "1M");
  EXPECT_EQ(countText(123456789), "123M");
  EXPECT_EQ(bytesText(3970), "3.97 kB");
  EXPECT_EQ(bytesText(12), "12 bytes");
  EXPECT_EQ(shellQuoted("a/b.pbrt"), "a/b.pbrt");
  EXPECT_EQ(shellQuoted("it's"), "'it'\\''s'");
  EXPECT_EQ(shellQuoted(""), "''");
}
