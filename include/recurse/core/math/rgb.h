/** @file
 * Colour triples: linear Rec. 709 primaries, D65 white. Radiance, flux, albedo and throughput are all Rgb.
 */
#pragma once

#include "recurse/core/math/vector.h"

namespace recurse {

/** Colour type, distinct from vectors to prevent mix-ups of both. All operations are by component. */
template <class T> struct RgbOf {
  T r, g, b;

  RgbOf() = default;
  constexpr explicit RgbOf(T grey) : r(grey), g(grey), b(grey) {}
  template <class R, class G, class B>
  constexpr RgbOf(R red, G green, B blue)
      : r(static_cast<T>(red)), g(static_cast<T>(green)), b(static_cast<T>(blue)) {}
  template <class U>
  constexpr explicit(sizeof(U) > sizeof(T)) RgbOf(const RgbOf<U>& c) : RgbOf(c.r, c.g, c.b) {}
  template <class U> constexpr explicit RgbOf(const glm::vec<3, U>& v) : RgbOf(v.x, v.y, v.z) {}
  template <class U> constexpr explicit operator glm::vec<3, U>() const { return {U(r), U(g), U(b)}; }

  constexpr T& operator[](int channel) { return channel == 0 ? r : channel == 1 ? g : b; }
  constexpr const T& operator[](int channel) const { return channel == 0 ? r : channel == 1 ? g : b; }

  constexpr RgbOf& operator+=(const RgbOf& c) { return *this = *this + c; }
  constexpr RgbOf& operator-=(const RgbOf& c) { return *this = *this - c; }
  constexpr RgbOf& operator*=(const RgbOf& c) { return *this = *this * c; }
  constexpr RgbOf& operator/=(const RgbOf& c) { return *this = *this / c; }
  constexpr RgbOf& operator*=(T s) { return *this = *this * s; }
  constexpr RgbOf& operator/=(T s) { return *this = *this / s; }

  friend constexpr RgbOf operator-(const RgbOf& a) { return {-a.r, -a.g, -a.b}; }
  friend constexpr RgbOf operator+(const RgbOf& a, const RgbOf& b) {
    return {a.r + b.r, a.g + b.g, a.b + b.b};
  }
  friend constexpr RgbOf operator-(const RgbOf& a, const RgbOf& b) {
    return {a.r - b.r, a.g - b.g, a.b - b.b};
  }
  friend constexpr RgbOf operator*(const RgbOf& a, const RgbOf& b) {
    return {a.r * b.r, a.g * b.g, a.b * b.b};
  }
  friend constexpr RgbOf operator/(const RgbOf& a, const RgbOf& b) {
    return {a.r / b.r, a.g / b.g, a.b / b.b};
  }
  friend constexpr RgbOf operator+(const RgbOf& a, T s) { return {a.r + s, a.g + s, a.b + s}; }
  friend constexpr RgbOf operator-(const RgbOf& a, T s) { return {a.r - s, a.g - s, a.b - s}; }
  friend constexpr RgbOf operator-(T s, const RgbOf& a) { return {s - a.r, s - a.g, s - a.b}; }
  friend constexpr RgbOf operator*(const RgbOf& a, T s) { return {a.r * s, a.g * s, a.b * s}; }
  friend constexpr RgbOf operator*(T s, const RgbOf& a) { return a * s; }
  friend constexpr RgbOf operator/(const RgbOf& a, T s) { return {a.r / s, a.g / s, a.b / s}; }
  friend constexpr RgbOf operator/(T s, const RgbOf& a) { return {s / a.r, s / a.g, s / a.b}; }
  /** Converts to other primaries, or adapts to a different white. */
  friend constexpr RgbOf operator*(const glm::mat<3, 3, T>& m, const RgbOf& a) {
    return RgbOf(m * glm::vec<3, T>(a));
  }
  friend constexpr bool operator==(const RgbOf&, const RgbOf&) = default;

  friend constexpr RgbOf min(const RgbOf& a, const RgbOf& b) {
    return map(a, b, [](T x, T y) { return y < x ? y : x; });
  }
  friend constexpr RgbOf max(const RgbOf& a, const RgbOf& b) {
    return map(a, b, [](T x, T y) { return x < y ? y : x; });
  }
  friend constexpr RgbOf max(const RgbOf& a, T s) { return max(a, RgbOf(s)); }
  friend constexpr RgbOf clamp(const RgbOf& a, T low, T high) { return min(max(a, low), RgbOf(high)); }
  friend RgbOf abs(const RgbOf& a) { return {std::abs(a.r), std::abs(a.g), std::abs(a.b)}; }
  friend RgbOf sqrt(const RgbOf& a) { return {std::sqrt(a.r), std::sqrt(a.g), std::sqrt(a.b)}; }
  friend RgbOf exp(const RgbOf& a) { return {std::exp(a.r), std::exp(a.g), std::exp(a.b)}; }
  friend RgbOf log(const RgbOf& a) { return {std::log(a.r), std::log(a.g), std::log(a.b)}; }

 private:
  template <class Function> static constexpr RgbOf map(const RgbOf& a, const RgbOf& b, const Function& f) {
    return {f(a.r, b.r), f(a.g, b.g), f(a.b, b.b)};
  }
};

using Rgb = RgbOf<float>;
using Rgbd = RgbOf<double>;

constexpr Rgb BLACK{0, 0, 0};

/** Relative luminance Y of linear Rec. 709 (ITU-R BT.709-6, item 3.2). */
template <class T> T luminance(const RgbOf<T>& c) {
  return T(0.2126) * c.r + T(0.7152) * c.g + T(0.0722) * c.b;
}
template <class T> T maxComponent(const RgbOf<T>& c) { return std::max(c.r, std::max(c.g, c.b)); }
template <class T> T channelSum(const RgbOf<T>& c) { return c.r + c.g + c.b; }
inline bool isFinite(const Rgb& c) { return std::isfinite(c.r) && std::isfinite(c.g) && std::isfinite(c.b); }
inline bool isBlack(const Rgb& c) { return c.r == 0 && c.g == 0 && c.b == 0; }

} // namespace recurse
