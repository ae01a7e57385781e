/** @file
 * Text for terminals: characters that are printed unchanged, and characters that are printed as bytes.
 */
#include <cstdio>
#include <string>

#include <gtest/gtest.h>

#include "recurse/core/io/terminalText.h"

using namespace recurse;

TEST(TerminalText, CharactersOfEveryLengthAreShown) {
  for (const char* text : {"plain\n\ttext", "\u00a0", "\u07ff", "\u0800", "\ud7ff", "\ue000", "\uffff",
                           "\U00010000", "\U0010ffff", "\u00e9\u6f22\U0001f600!"})
    EXPECT_EQ(terminalText(text), text);
}

TEST(TerminalText, ControlCharactersAreShownAsBytes) {
  EXPECT_EQ(terminalText("a\x1b[2Jb\x7f"), "a\\x1b[2Jb\\x7f");
  EXPECT_EQ(terminalText("\xc2\x9b["), "\\xc2\\x9b[");
  EXPECT_TRUE(hasControlCharacters("a\tb"));
  EXPECT_FALSE(hasControlCharacters("\u00e9\u6f22"));
}

TEST(TerminalText, BytesThatAreNotUtf8AreShownAsBytes) {
  const auto expectBytes = [](const std::string& bytes) {
    std::string escaped;
    for (const char c : bytes) {
      char text[5];
      std::snprintf(text, sizeof text, "\\x%02x", static_cast<unsigned char>(c));
      escaped += text;
    }
    EXPECT_EQ(terminalText(bytes), escaped);
    EXPECT_TRUE(hasControlCharacters(bytes)) << escaped;
  };
  // Overlong forms: the control character U+009B in three and four bytes, and the smallest characters that
  // need one byte less.
  for (const char* overlong :
       {"\xc1\x9b", "\xe0\x82\x9b", "\xe0\x9f\xbf", "\xf0\x80\x82\x9b", "\xf0\x8f\xbf\xbf"})
    expectBytes(overlong);
  for (const char* surrogate : {"\xed\xa0\x80", "\xed\xbf\xbf"}) expectBytes(surrogate);
  for (const char* tooHigh : {"\xf4\x90\x80\x80", "\xf5\x80\x80\x80", "\xff"}) expectBytes(tooHigh);
  for (const char* cut : {"\xe6\xbc", "\xf0\x9f\x98", "\xc3", "\x80"}) expectBytes(cut);
}
