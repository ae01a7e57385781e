/** @file
 * The reader of JSON.
 */
#include "importers/assimp/json.h"

#include <gtest/gtest.h>
#include <limits>

#include "recurse/core/io/error.h"

using namespace recurse;

TEST(Json, ValuesAreFoundByNamesAndIndices) {
  const JsonValue file = JsonValue::parse(
      "\xef\xbb\xbf { \"a\" : [ 1, -2.5e1 , true,null, {\"b\":\"c\"} ],\"empty\":{} ,\"none\":[]}\n");
  EXPECT_EQ(file.size(), 3u);
  const JsonValue& list = file["a"];
  ASSERT_EQ(list.size(), 5u);
  EXPECT_EQ(list.elements()[0].index(), 1u);
  EXPECT_EQ(list.elements()[1].number(0), -25);
  EXPECT_EQ(list.elements()[1].index(), std::numeric_limits<size_t>::max());
  EXPECT_EQ(list.elements()[2].number(7), 7);
  EXPECT_EQ(list[size_t(4)]["b"].text(), "c");
  EXPECT_EQ(file["x"][size_t(9)]["y"].text(), "") << "what is absent is null";
  EXPECT_EQ(file["x"].number(3), 3);
}

TEST(Json, EscapesAreDecodedToUtf8) {
  EXPECT_EQ(JsonValue::parse(R"("\"\\\/\n\u0041\u00e9\u20ac\ud83d\ude00")").text(),
            "\"\\/\nA\xc3\xa9\xe2\x82\xac\xf0\x9f\x98\x80");
}

TEST(Json, FaultsAreErrorsWithTheirByte) {
  const auto fault = [](const std::string& text) -> std::string {
    try {
      JsonValue::parse(text);
    } catch (const Error& e) {
      return e.what();
    }
    return "none";
  };
  EXPECT_EQ(fault("[1,2"), "byte 4 of the JSON text should be ',' or ']'");
  EXPECT_EQ(fault("{\"a\" 1}"), "byte 5 of the JSON text should be ':'");
  EXPECT_EQ(fault("{a:1}"), "byte 1 of the JSON text should be '\"'");
  EXPECT_EQ(fault("[1,]"), "byte 3 of the JSON text should be a value");
  EXPECT_EQ(fault("1 2"), "byte 2 of the JSON text should be the end of the text");
  EXPECT_EQ(fault("\"abc"), "byte 1 of the JSON text should be in a string that ends");
  EXPECT_EQ(fault("\"\\x\""), "byte 2 of the JSON text should be a character that can be escaped");
  EXPECT_EQ(fault("\"\\u12g4\""), "byte 3 of the JSON text should be four hexadecimal digits");
  EXPECT_EQ(fault(""), "byte 0 of the JSON text should be a value");
  EXPECT_NE(fault(std::string(100000, '[')).find("less deeply nested"), std::string::npos);
}
