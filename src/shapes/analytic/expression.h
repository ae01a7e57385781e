/** @file
 * Functions of x, y and z from text, for shapes that are level sets. An expression is a list of instructions,
 * which runs on numbers, on intervals, and on either together with derivatives.
 */
#pragma once

#include <array>
#include <string>
#include <vector>

#include "recurse/core/io/error.h"
#include "recurse/core/math/vector.h"
#include "shapes/analytic/interval.h"

namespace recurse {

/** Error in the text of an expression. */
struct ExpressionError {
  size_t offset = 0; ///< in the text [characters]
  std::string message;
  std::string accepted; ///< what would be accepted; may be empty
};

/** Location of a character of a quoted string in a scene file, where the string begins at `string`. */
SourceLocation locationInString(const SourceLocation& string, size_t offset);

/** Value and derivative along a line (automatic differentiation, forward mode). */
struct Slope {
  Interval value, slope;
};

/** Value, gradient and second derivatives. */
struct Jet {
  double value = 0;
  Vec3d gradient{0};
  Mat3d second{0};
};

class Expression {
 public:
  enum class Operation : uint8_t {
    CONSTANT,
    X,
    Y,
    Z,
    ADD,
    SUBTRACT,
    MULTIPLY,
    DIVIDE,
    MINIMUM,
    MAXIMUM,
    NEGATE,
    ABSOLUTE,
    SQUARE_ROOT,
    SINE,
    COSINE,
    EXPONENTIAL,
    LOGARITHM,
    WHOLE_POWER, ///< to the power of an integer
    REAL_POWER   ///< to the power of another constant, defined for bases >= 0
  };
  struct Instruction {
    Operation operation = Operation::CONSTANT;
    uint32_t a = 0, b = 0; ///< operands: numbers of earlier instructions
    double constant = 0;   ///< value or exponent
    bool operator==(const Instruction&) const = default;
  };
  static constexpr size_t MOST_INSTRUCTIONS = 1000;

  /** Throws ExpressionError. */
  explicit Expression(const std::string& text);

  size_t size() const { return instructions.size(); }

  /** Value at a point; not a number where it is undefined. */
  double value(const Vec3d& p) const;
  Interval value(const std::array<Interval, 3>& p) const;
  Slope slope(const std::array<Slope, 3>& p) const;
  Jet jet(const Vec3d& p) const;

 private:
  std::vector<Instruction> instructions; ///< the last one yields the value
};

} // namespace recurse
