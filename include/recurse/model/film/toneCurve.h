/** @file
 * Tools of tone operators: curves that preserve the grey card, colours of a given luminance, blurred images.
 */
#pragma once

#include <algorithm>
#include <vector>

#include "recurse/model/film/toneMap.h"

namespace recurse {

/** Scale s for which curve(s · GREY_CARD) = GREY_CARD; the curve must increase, from 0 to above GREY_CARD. */
template <class Curve> float greyKeepingScale(const Curve& curve) {
  float low = 0, high = 1;
  while (curve(high * GREY_CARD) < GREY_CARD) high *= 2;
  for (int i = 0; i < 40; ++i) {
    const float middle = 0.5f * (low + high);
    (curve(middle * GREY_CARD) < GREY_CARD ? low : high) = middle;
  }
  return 0.5f * (low + high);
}

/** Replaces each colour of the image, its first three channels, by change(colour); row by row. */
template <class Change> void changeColours(Image& picture, const Change& change) {
  const size_t stride = picture.channels.size();
  for (size_t i = 0; i + 2 < picture.pixels.size(); i += stride) {
    float* p = &picture.pixels[i];
    const Rgb colour = change(Rgb(p[0], p[1], p[2]));
    std::copy_n(&colour.r, 3, p);
  }
}

/** Colour scaled to luminance y. Where a channel would exceed 1, the colour is moved towards the grey y until
 * its largest channel is 1; for y >= 1 it is that grey. Black stays black. */
inline Rgb withLuminance(const Rgb& colour, float y) {
  const float before = luminance(colour);
  if (!(before > 0)) return BLACK;
  const Rgb scaled = colour * (y / before);
  const float largest = maxComponent(scaled);
  return largest <= 1 ? scaled : y >= 1 ? Rgb(y) : Rgb(y) + (scaled - y) * ((1 - y) / (largest - y));
}

/** Luminance quantile: the fraction `q`, in [0, 1], of the pixels is darker; 0 without pixels. */
float luminanceQuantile(const Image& picture, double q);

/** Luminance of each pixel, row by row. */
std::vector<float> luminances(const Image& picture);

/** Gaussian blur of a field of width × height numbers, with standard deviation `sigma` [pixels]; none for 0.
 * At the border the mean is over the pixels inside. From 16 pixels on it is computed on a smaller image. */
std::vector<float> gaussianBlur(const std::vector<float>& field, int width, int height, float sigma);

} // namespace recurse
