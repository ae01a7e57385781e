/** @file
 * Tokens: numbers in all forms, strings with escapes, comments, positions.
 */
#include "scene/text/lexer.h"
#include "sceneTesting.h"

using namespace recurse;
using namespace recurse::sceneFile;

namespace {

struct Text {
  explicit Text(const std::string& text) {
    source.text = std::make_shared<const SourceText>(SourceText{"t", text});
  }
  Source source;
};

double number(const std::string& text) {
  const Text t(text);
  Lexer lexer(t.source);
  return numberValue(lexer.next());
}

std::string stringValue(const std::string& text) {
  const Text t(text);
  Lexer lexer(t.source);
  return lexer.next().value();
}

} // namespace

TEST(Lexer, Numbers) {
  EXPECT_EQ(number("1"), 1);
  EXPECT_EQ(number("1e3"), 1000);
  EXPECT_EQ(number("-.5"), -0.5);
  EXPECT_EQ(number("+3"), 3);
  EXPECT_EQ(number("+.25E1"), 2.5);
  EXPECT_EQ(number("5."), 5);
  EXPECT_EQ(number("-1.13687e-13"), -1.13687e-13);
  EXPECT_EQ(number("0.1"), 0.1);
  EXPECT_EQ(number("1e-999"), 0);
  for (const char* bad :
       {"1e999", "nan", "inf", "-infinity", "1,2", "5f", "0x10", "--1", "+-1", "-", ".", "abc"})
    EXPECT_THROW(number(bad), SceneError) << bad;
}

TEST(Lexer, FastNumbersStopWhereTheyShould) {
  const Text t("1 2 # comment 7\n+3\n\t-4.5e1]6");
  Lexer lexer(t.source);
  std::vector<double> values;
  lexer.appendNumbers(values);
  EXPECT_EQ(values, (std::vector<double>{1, 2, 3, -45}));
  const Token close = lexer.next();
  EXPECT_EQ(close.kind, TokenKind::CLOSE);
  EXPECT_EQ(close.line, 3);
  EXPECT_EQ(close.column, 8);
  EXPECT_EQ(lexer.next().text, "6");
  EXPECT_EQ(lexer.next().kind, TokenKind::END);
  EXPECT_EQ(lexer.next().kind, TokenKind::END);
}

TEST(Lexer, Strings) {
  EXPECT_EQ(stringValue(R"("plain text")"), "plain text");
  EXPECT_EQ(stringValue(R"("a\\b\"c\n\t\'\r\b\f")"), "a\\b\"c\n\t'\r\b\f");
  EXPECT_EQ(stringValue(R"("# no comment [ ]")"), "# no comment [ ]");
  EXPECT_THROW(stringValue(R"("C:\query")"), SceneError);
  EXPECT_THROW(stringValue("\"open"), SceneError);
  EXPECT_THROW(stringValue("\"open\nnext\""), SceneError);
  EXPECT_THROW(stringValue("\"open\\"), SceneError);
}

TEST(Lexer, EscapePlace) {
  try {
    stringValue("  \"ab\\q\"");
    FAIL();
  } catch (const SceneError& e) {
    EXPECT_EQ(e.diagnostics().at(0).location.column, 6);
  }
}

TEST(Lexer, ByteOrderMarkAndNoNewlineAtTheEnd) {
  const Text t("\xef\xbb\xbfWorldBegin");
  Lexer lexer(t.source);
  EXPECT_EQ(lexer.next().text, "WorldBegin");
}
