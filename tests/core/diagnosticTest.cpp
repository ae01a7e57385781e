/** @file
 * Diagnostics: the caret below the line of a scene file, and truncation of long texts.
 */
#include <gtest/gtest.h>

#include "recurse/core/io/error.h"

using namespace recurse;

namespace {

/** The two lines below a message for a byte of a line. */
std::string caretLinesAt(const std::string& line, size_t byte) {
  Diagnostic d;
  d.location = {std::make_shared<SourceText>(SourceText{"a.pbrt", "\n" + line + "\n"}), 2, int(byte) + 1};
  d.message = "wrong";
  const std::string text = d.format(), first = "a.pbrt:2:" + std::to_string(byte + 1) + ": error: wrong\n";
  EXPECT_EQ(text.substr(0, first.size()), first);
  return text.substr(first.size());
}

std::string repeated(const std::string& text, size_t times) {
  std::string out;
  for (size_t i = 0; i < times; ++i) out += text;
  return out;
}

} // namespace

TEST(Caret, IsBelowItsCharacter) {
  EXPECT_EQ(caretLinesAt("Shape \"ball\"", 6), "    Shape \"ball\"\n          ^\n");
  EXPECT_EQ(caretLinesAt("# \u00e9\u6f22\U0001f600 ball", 12),
            "    # \u00e9\u6f22\U0001f600 ball\n          ^\n");
  EXPECT_EQ(caretLinesAt("ab", 2), "    ab\n      ^\n");         // behind the last character
  EXPECT_EQ(caretLinesAt("\u00e9b", 1), "    \u00e9b\n    ^\n"); // within a character
}

TEST(Caret, ControlCharactersAndBytesThatAreNotUtf8AreOneBlank) {
  EXPECT_EQ(caretLinesAt("a\tb\x7f\xc2\x9b"
                         "c\xff!",
                         8),
            "    a b  c !\n           ^\n");
}

TEST(Caret, LongLinesAreCutBetweenCharacters) {
  const std::string e = "\u00e9";
  EXPECT_EQ(caretLinesAt(repeated(e, 100), 160),
            "    " + repeated(e, 100) + "\n" + std::string(84, ' ') + "^\n");
  EXPECT_EQ(caretLinesAt(repeated(e, 150), 0), "    " + repeated(e, 100) + "...\n    ^\n");
  EXPECT_EQ(caretLinesAt("a" + repeated(e, 200), 201),
            "    ..." + repeated(e, 100) + "...\n" + std::string(57, ' ') + "^\n");
  EXPECT_EQ(caretLinesAt(repeated(e, 150), 298),
            "    ..." + repeated(e, 51) + "\n" + std::string(57, ' ') + "^\n");
}

TEST(Diagnostics, LongMessagesAreCutBetweenCharacters) {
  Diagnostics diagnostics;
  diagnostics.error({}, "a" + repeated("\u00e9", 400) + "b");
  EXPECT_EQ(diagnostics.all().front().message,
            "a" + repeated("\u00e9", 149) + "[...]" + repeated("\u00e9", 149) + "b");
}
