/** @file
 * Image files by OpenImageIO. Encoders write to memory, and one function writes the bytes to the disk and
 * checks every error, which the file handling of the encoders does not always do.
 */
#include "recurse/core/image/image.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>

#include <OpenImageIO/filesystem.h>

#include "core/image/imageInput.h"
#include "core/image/pcx.h"
#include "recurse/core/io/atomicFile.h"
#include "recurse/core/io/error.h"
#include "recurse/core/io/files.h"
#include "recurse/core/io/text.h"
#include "recurse/core/threads/resources.h"

namespace recurse {

namespace {

std::string extensionOf(const std::string& fileName) {
  return lowerCase(std::filesystem::path(fileName).extension().string());
}

/** Content of a file by its extension. */
enum class Content { ALL_CHANNELS, LINEAR_RGB, DISPLAY_RGB };

/** `others`: further extensions that the caller accepts, each after a space. */
Content contentByExtension(const std::string& fileName, const std::string& others = {}) {
  const std::string extension = extensionOf(fileName);
  if (extension == ".exr") return Content::ALL_CHANNELS;
  if (extension == ".hdr" || extension == ".pfm") return Content::LINEAR_RGB;
  for (const char* known : {".png", ".jpg", ".jpeg", ".tif", ".tiff"})
    if (extension == known) return Content::DISPLAY_RGB;
  throw Error(fileName + ": cannot be written: " +
                  (extension.empty() ? "the name has no extension" : "unknown extension " + extension) +
                  "; accepted: .exr .hdr .pfm .png .jpg .jpeg .tif .tiff" + others,
              ExitStatus::BAD_USAGE);
}

/** Encoded value in [0, 1] as a byte; NaN becomes 0, black. */
uint8_t byteOf(float encoded) {
  return encoded > 0 ? static_cast<uint8_t>(std::lround(255 * std::min(encoded, 1.0f))) : 0;
}

/** R, G, B of each pixel; a single channel gives grey. Throws Error for two channels or none. */
std::vector<float> rgbPixels(const std::string& fileName, const Image& image) {
  const size_t channels = image.channels.size();
  if (channels == 2 || channels == 0)
    throw Error(fileName + ": cannot be written: a picture of this kind needs R, G and B");
  const size_t count = size_t(image.width) * size_t(image.height);
  std::vector<float> out(count * 3);
  for (size_t i = 0; i < count; ++i)
    for (size_t c = 0; c < 3; ++c) out[i * 3 + c] = image.pixels[i * channels + (channels >= 3 ? c : 0)];
  return out;
}

/** True for attributes that are specific to a file format, and meaningless or misleading in other files. */
bool isFormatAttribute(const std::string& name) {
  const std::string lower = lowerCase(name);
  for (const char* prefix : {"oiio:", "openexr:", "png:", "jpeg:", "tiff:", "exif:", "gps:", "icc", "iptc:"})
    if (lower.starts_with(prefix)) return true;
  for (const char* known : {"compression", "chromaticities", "datetime", "orientation", "pixelaspectratio",
                            "resolutionunit", "xresolution", "yresolution", "screenwindowcenter",
                            "screenwindowwidth", "worldtocamera", "worldtoscreen", "planarconfig"})
    if (lower == known) return true;
  return false;
}

std::vector<unsigned char> encode(const std::string& fileName, const OIIO::ImageSpec& spec,
                                  OIIO::TypeDesc type, const void* pixels) {
  const std::unique_ptr<OIIO::ImageOutput> output =
      OIIO::ImageOutput::create(extensionOf(fileName).substr(1));
  if (!output) throw Error(fileName + ": cannot be written: " + OIIO::geterror());
  OIIO::Filesystem::IOVecOutput memory;
  if (!output->supports("ioproxy") || !output->set_ioproxy(&memory))
    throw Error(fileName + ": cannot be written: the image library has no memory encoder for this format");
  if (!output->open(fileName, spec) || !output->write_image(type, pixels) || !output->close())
    throw Error(fileName + ": cannot be written: " + output->geterror());
  output->geterror(); // warnings about metadata; unread ones would be printed
  return memory.buffer();
}

/** Encodes PFM, for which OpenImageIO 2.4 has no writer: three header lines, then rows from the bottom in the
 * byte order of the machine. */
std::vector<unsigned char> encodePfm(const Image& image, const std::vector<float>& rgb) {
  const char* order = std::endian::native == std::endian::little ? "-1.0" : "1.0";
  const std::string header =
      "PF\n" + std::to_string(image.width) + " " + std::to_string(image.height) + "\n" + order + "\n";
  std::vector<unsigned char> out(header.begin(), header.end());
  const size_t row = size_t(image.width) * 3;
  for (size_t y = size_t(image.height); y-- > 0;) {
    const auto* bytes = reinterpret_cast<const unsigned char*>(&rgb[y * row]);
    out.insert(out.end(), bytes, bytes + row * sizeof(float));
  }
  return out;
}

/** Adds half a step of RGBE to each channel, since OpenImageIO cuts mantissas instead of rounding them. A
 * step is 1/256 of the power of two above the brightest channel. */
void addHalfSteps(std::vector<float>& rgb) {
  for (auto pixel = rgb.begin(); pixel != rgb.end(); pixel += 3) {
    const float brightest = *std::max_element(pixel, pixel + 3);
    if (!(brightest > 0 && std::isfinite(brightest))) continue;
    int exponent = 0;
    std::frexp(brightest, &exponent);
    for (int c = 0; c < 3; ++c) pixel[c] += std::ldexp(0.5f, exponent - 8);
  }
}

std::vector<unsigned char> encodeImage(const std::string& fileName, const Image& image,
                                       const ImageWriteOptions& options) {
  const Content content = contentByExtension(fileName);
  if (image.width < 1 || image.height < 1) throw Error(fileName + ": cannot be written: it has no pixels");
  const auto addMetadata = [&image](OIIO::ImageSpec& spec) {
    for (const auto& [name, value] : image.metadata)
      if (!isFormatAttribute(name)) spec.attribute(name, value);
  };
  if (content == Content::ALL_CHANNELS) {
    OIIO::ImageSpec spec(image.width, image.height, static_cast<int>(image.channels.size()),
                         OIIO::TypeDesc::FLOAT);
    spec.channelnames = image.channels;
    spec.attribute("compression", "zip");
    static constexpr float REC_709[8] = {0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f};
    spec.attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), REC_709);
    spec.attribute("oiio:ColorSpace", "Linear");
    addMetadata(spec);
    return encode(fileName, spec, OIIO::TypeDesc::FLOAT, image.pixels.data());
  }
  std::vector<float> rgb = rgbPixels(fileName, image);
  if (extensionOf(fileName) == ".pfm") return encodePfm(image, rgb);
  if (content == Content::LINEAR_RGB) {
    OIIO::ImageSpec spec(image.width, image.height, 3, OIIO::TypeDesc::FLOAT);
    addMetadata(spec);
    addHalfSteps(rgb);
    return encode(fileName, spec, OIIO::TypeDesc::FLOAT, rgb.data());
  }
  std::vector<uint8_t> bytes(rgb.size());
  const float scale = std::exp2(options.exposure);
  std::transform(rgb.begin(), rgb.end(), bytes.begin(), [&](float x) {
    return byteOf(options.encoded ? x : srgbFromLinear(std::min(x * scale, 1.0f)));
  });
  OIIO::ImageSpec spec(image.width, image.height, 3, OIIO::TypeDesc::UINT8);
  const std::string format = extensionOf(fileName);
  if (format == ".jpg" || format == ".jpeg") {
    spec.attribute("compression", "jpeg:95");
    spec.attribute("jpeg:subsampling", "4:4:4");
  }
  // For TIFF the attribute would go into an Exif block, which the encoder cannot write to memory.
  if (!format.starts_with(".tif")) spec.attribute("oiio:ColorSpace", "sRGB");
  addMetadata(spec);
  return encode(fileName, spec, OIIO::TypeDesc::UINT8, bytes.data());
}

} // namespace

// The transfer functions of IEC 61966-2-1.
float srgbFromLinear(float x) {
  return x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1 / 2.4f) - 0.055f;
}
float linearFromSrgb(float x) { return x <= 0.04045f ? x / 12.92f : std::pow((x + 0.055f) / 1.055f, 2.4f); }

std::vector<int> channelOrder(const std::string& fileName, const std::vector<std::string>& names) {
  const auto find = [&names](const std::string& wanted) -> std::optional<int> {
    for (size_t i = 0; i < names.size(); ++i)
      if (lowerCase(names[i]) == wanted) return static_cast<int>(i);
    return std::nullopt;
  };
  std::vector<int> first;
  const auto takeColours = [&](const std::string& prefix) {
    const std::optional<int> r = find(prefix + "r"), g = find(prefix + "g"), b = find(prefix + "b");
    if (r && g && b) first = {*r, *g, *b};
    return !first.empty();
  };
  if (!takeColours(""))
    for (const std::string& name : names) // the first layer with colours
      if (name.size() > 2 && lowerCase(name).ends_with(".r") &&
          takeColours(lowerCase(name.substr(0, name.size() - 1))))
        break;
  const std::optional<int> alpha = find("a");
  if (first.empty() && names.size() - (alpha ? 1 : 0) == 1) {
    const int grey = alpha && *alpha == 0 ? 1 : 0;
    first = {grey, grey, grey};
  }
  if (first.empty()) {
    std::string list;
    for (const std::string& name : names) list += " " + name;
    throw Error(fileName + ": has neither R, G, B nor a single channel; its channels are:" + list);
  }
  std::vector<int> order = first;
  for (int i = 0; i < static_cast<int>(names.size()); ++i)
    if (std::find(first.begin(), first.end(), i) == first.end()) order.push_back(i);
  return order;
}

bool isDisplayFormat(const std::string& fileName) {
  return contentByExtension(fileName) == Content::DISPLAY_RGB;
}

Image withChannels(const Image& picture, const Image& more) {
  std::vector<std::string> channels = picture.channels;
  channels.insert(channels.end(), more.channels.begin(), more.channels.end());
  Image out(picture.width, picture.height, channels);
  out.metadata = picture.metadata;
  out.metadata.insert(more.metadata.begin(), more.metadata.end());
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      float* const rest = std::copy_n(picture.at(x, y), picture.channels.size(), out.at(x, y));
      std::copy_n(more.at(x, y), more.channels.size(), rest);
    }
  return out;
}

int Image::channel(const std::string& name) const {
  const auto found = std::find(channels.begin(), channels.end(), name);
  return found == channels.end() ? -1 : static_cast<int>(found - channels.begin());
}

namespace detail {

namespace {

void requireFile(const std::string& fileName) {
  std::error_code error;
  const auto status = std::filesystem::status(fileName, error);
  if (!std::filesystem::exists(status))
    throw Error(fileName +
                ": cannot be read: " + (error ? error.message() : std::string("No such file or directory")));
  requireReadable(fileName);
}

void requirePictureMemory(const std::string& fileName, const OIIO::ImageSpec& spec, double bytesPerPixel) {
  requireMemory(fileName + ": a picture of " + std::to_string(spec.width) + "x" +
                    std::to_string(spec.height) + " pixels",
                double(spec.width) * double(spec.height) * bytesPerPixel);
}

std::string readWholeFile(const std::string& fileName) {
  std::ifstream in(fileName, std::ios::binary);
  std::string content(std::istreambuf_iterator<char>(in), {});
  if (in.bad()) throw Error(fileName + ": cannot be read");
  return content;
}

} // namespace

OpenImage openImage(const FileReference& file) {
  const std::string& fileName = file.path;
  OpenImage image;
  image.content = file.content;
  if (!image.content) requireFile(fileName);
  std::string readerName = fileName;
  if (extensionOf(fileName) == ".pcx") {
    image.content = std::make_shared<const std::string>(
        tgaOfPcx(fileName, image.content ? *image.content : readWholeFile(fileName)));
    readerName += ".tga";
  }
  OIIO::ImageSpec asStored;
  asStored.attribute("oiio:UnassociatedAlpha", 1);
  if (image.content) {
    image.memory = std::make_unique<OIIO::Filesystem::IOMemReader>(const_cast<char*>(image.content->data()),
                                                                   image.content->size());
    OIIO::Filesystem::IOProxy* const proxy = image.memory.get();
    asStored.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
    image.input = OIIO::ImageInput::open(readerName, &asStored, proxy);
  } else {
    image.input = OIIO::ImageInput::open(readerName, &asStored);
  }
  if (!image.input) throw Error(fileName + ": cannot be read: " + readFailure(OIIO::geterror()));
  const OIIO::ImageSpec& spec = image.input->spec();
  if (spec.width < 1 || spec.height < 1 || spec.depth > 1 || spec.nchannels < 1)
    throw Error(fileName + ": cannot be read: not a picture of two dimensions");
  requirePictureMemory(fileName, spec, double(spec.nchannels) * double(spec.format.size()));
  return image;
}

namespace {

constexpr const char* LACKS_MEMORY = "it needs more memory than is available";

} // namespace

Error lacksMemory(const FileReference& file) {
  return Error(file.path + ": cannot be read: " + LACKS_MEMORY);
}

std::string readFailure(const std::string& said) {
  if (said.find("std::bad_alloc") != std::string::npos) return LACKS_MEMORY;
  return said.empty() ? "it is cut off or damaged" : said;
}

} // namespace detail

Image readImage(const FileReference& file) try {
  const std::string& fileName = file.path;
  const detail::OpenImage input = detail::openImage(file);
  const OIIO::ImageSpec& spec = input->spec();
  const std::vector<int> order = channelOrder(fileName, spec.channelnames);
  const size_t stored = size_t(spec.nchannels);
  detail::requirePictureMemory(fileName, spec, double(stored + order.size()) * sizeof(float));
  std::vector<float> pixels(size_t(spec.width) * size_t(spec.height) * stored);
  if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, pixels.data()))
    throw Error(fileName + ": cannot be read: " + detail::readFailure(input.input->geterror()));

  const bool grey = order[0] == order[1];
  const int alpha = detail::alphaChannel(spec);
  std::vector<std::string> names;
  for (int i : order) names.push_back(spec.channelnames[size_t(i)]);
  if (grey) std::copy_n(std::array{"R", "G", "B"}.begin(), 3, names.begin());
  Image image(spec.width, spec.height, names);
  image.fromIntegers = !spec.format.is_floating_point();
  const bool coded =
      image.fromIntegers && lowerCase(spec.get_string_attribute("oiio:ColorSpace", "sRGB")) != "linear";
  const size_t count = size_t(spec.width) * size_t(spec.height);
  for (size_t i = 0; i < count; ++i)
    for (size_t c = 0; c < order.size(); ++c) {
      const float value = pixels[i * stored + size_t(order[c])];
      image.pixels[i * order.size() + c] = coded && order[c] != alpha ? linearFromSrgb(value) : value;
    }
  for (const OIIO::ParamValue& attribute : spec.extra_attribs)
    image.metadata[attribute.name().string()] = attribute.get_string();
  return image;
} catch (const std::bad_alloc&) {
  throw detail::lacksMemory(file);
}

std::vector<unsigned char> encodedPng(const Image& encoded) {
  return encodeImage("frame.png", encoded, {.encoded = true});
}

void writeImage(const std::string& fileName, const Image& image, const ImageWriteOptions& options) {
  const std::vector<unsigned char> bytes = encodeImage(fileName, image, options);
  AtomicFile file(fileName);
  file.write(bytes.data(), bytes.size());
  file.commit();
}

void checkImageWritable(const std::string& fileName, const std::string& others) {
  contentByExtension(fileName, others);
  checkFileWritable(fileName);
}

void writeFileAtomically(const std::string& fileName, const std::string& text) {
  AtomicFile file(fileName);
  file.write(text.data(), text.size());
  file.commit();
}

} // namespace recurse
