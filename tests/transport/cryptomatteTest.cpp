/** @file
 * Cryptomattes against the hashes of the specification, and against known areas.
 */
#include "transport/rendering.h"

#include <bit>
#include <map>

#include "recurse/render/featureLayers.h"
#include "render/cryptomatte.h"

using namespace recurse;

namespace {

/** Orthographic view along z: two units of height on 40 pixels. */
const std::string HEAD =
    "Film \"rgb\" \"integer xresolution\" 40 \"integer yresolution\" 40\n"
    "PixelFilter \"box\"\nLookAt 0 0 -9  0 0 0  0 1 0\nCamera \"orthographic\"\nWorldBegin\n";

/** Sum over all pixels of the coverage of each id of a matte. */
std::map<uint32_t, double> coverage(const Image& image, const std::string& matte) {
  std::map<uint32_t, double> out;
  for (const char* layer : {"00", "01", "02"})
    for (const auto& [id, part] : {std::pair(".R", ".G"), std::pair(".B", ".A")}) {
      const int i = image.channel(matte + layer + id), p = image.channel(matte + layer + part);
      EXPECT_GE(i, 0);
      EXPECT_GE(p, 0);
      for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
          out[std::bit_cast<uint32_t>(image.at(x, y)[i])] += double(image.at(x, y)[p]);
    }
  return out;
}

Image mattes(const std::string& text, bool throughSpecular = false) {
  const auto scene = recurse::testing::sceneFrom(HEAD + text);
  const auto path = recurse::testing::integratorFrom("path", "");
  return renderFeatures(*scene, *path, {{"cryptoobject", "cryptomaterial"}, 16, throughSpecular, 1});
}

} // namespace

TEST(Cryptomatte, HashesNamesByTheConvention) {
  // Examples of the specification, and its rule for exponents.
  EXPECT_EQ(cryptomatteId("hello"), 0x248bfa47u);
  EXPECT_EQ(cryptomatteId("bunny"), 0x13851a76u);
  EXPECT_EQ(cryptomatteId("CryptoObject"), 0x3ae39a58u);
  EXPECT_EQ(cryptomatteId("CryptoMaterial"), 0xbe359d67u);
  EXPECT_EQ(cryptomatteId("special_chars"), 0xfbb35e3du);
  EXPECT_EQ(cryptomatteId("\u0440\u0430\u0432\u043d\u0438\u043d\u0430"), 0x9623511eu);
  EXPECT_EQ(cryptomatteId("obj45"), 0x00f34d5cu);
  EXPECT_EQ(cryptomatteId("obj520"), 0x7f3b01edu);
  EXPECT_EQ(cryptomatteId(""), 0x00800000u);
}

TEST(Cryptomatte, CoversWhatObjectsCover) {
  const Image image =
      mattes("MakeNamedMaterial \"wood\" \"string type\" \"diffuse\"\n"
             "ObjectBegin \"ball\"\nNamedMaterial \"wood\"\nShape \"sphere\" \"float radius\" .3\nObjectEnd\n"
             "AttributeBegin\nTranslate -.5 .5 0\nObjectInstance \"ball\"\nAttributeEnd\n"
             "AttributeBegin\nTranslate .5 -.5 0\nObjectInstance \"ball\"\nAttributeEnd\n"
             "AttributeBegin\nAreaLightSource \"diffuse\"\nMaterial \"interface\"\nTranslate -.5 -.5 0\n"
             "Shape \"disk\" \"float radius\" .4\nAttributeEnd\n"
             "Material \"conductor\"\nTranslate .6 .6 0\nShape \"disk\" \"float radius\" .2\n");
  ASSERT_EQ(image.channels.size(), 24u);
  const double disc = INV_PI > 0 ? 400 / double(INV_PI) : 0; // area of a disc of radius 1 in pixels
  auto objects = coverage(image, "CryptoObject");
  objects.erase(0);
  ASSERT_EQ(objects.size(), 4u);
  EXPECT_NEAR(objects[cryptomatteId("ball")], disc * 0.09, 0.6);
  EXPECT_NEAR(objects[cryptomatteId("ball.2")], disc * 0.09, 0.6);
  EXPECT_NEAR(objects[cryptomatteId("disk")], disc * 0.16, 0.8);
  EXPECT_NEAR(objects[cryptomatteId("disk.2")], disc * 0.04, 0.4);
  auto materials = coverage(image, "CryptoMaterial");
  materials.erase(0);
  ASSERT_EQ(materials.size(), 2u); // the lamp has no material
  EXPECT_NEAR(materials[cryptomatteId("wood")], disc * 0.18, 1.2);
  EXPECT_NEAR(materials[cryptomatteId("conductor")], disc * 0.04, 0.4);
  for (const auto& [key, name] :
       {std::pair("3ae39a5", "CryptoObject"), std::pair("be359d6", "CryptoMaterial")})
    EXPECT_EQ(image.metadata.at("cryptomatte/" + std::string(key) + "/name"), name);
  EXPECT_EQ(image.metadata.at("cryptomatte/be359d6/manifest").find("\"wood\":\""),
            image.metadata.at("cryptomatte/be359d6/manifest").find("\"wood\""));
  EXPECT_NE(image.metadata.at("cryptomatte/3ae39a5/manifest").find("\"ball.2\":"), std::string::npos);
}

TEST(Cryptomatte, RanksFallAndAddUpToNoMoreThanTheWhole) {
  const Image image = mattes("Material \"diffuse\"\nShape \"sphere\" \"float radius\" .5\n"
                             "Translate .2 0 2\nShape \"sphere\" \"float radius\" .6\n");
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const float* p = image.at(x, y);
      float sum = 0;
      for (int rank = 0; rank < 6; ++rank) {
        sum += p[2 * rank + 1];
        if (rank > 0) {
          EXPECT_LE(p[2 * rank + 1], p[2 * rank - 1]);
        }
      }
      EXPECT_LE(sum, 1.0001f);
    }
}

TEST(Cryptomatte, MirrorsAreLookedThroughOnRequest) {
  const std::string room = "Material \"conductor\"\nShape \"disk\" \"float radius\" 9\n"
                           "Material \"diffuse\"\nTranslate 0 0 -20\nShape \"sphere\" \"float radius\" 8\n";
  auto on = coverage(mattes(room), "CryptoMaterial");
  EXPECT_NEAR(on[cryptomatteId("conductor")], 1600, 1e-3);
  auto in = coverage(mattes(room, true), "CryptoMaterial");
  EXPECT_NEAR(in[cryptomatteId("diffuse")], 1600, 1e-3);
}
