/** @file
 * Parser and interpreter of expressions.
 */
#include "shapes/analytic/expression.h"

#include <charconv>

namespace recurse {

namespace {

// ---- arithmetic of numbers

double minimum(double a, double b) { return a < b || std::isnan(a) ? a : b; }
double maximum(double a, double b) { return a > b || std::isnan(a) ? a : b; }
double absolute(double a) { return std::abs(a); }
double squareRoot(double a) { return std::sqrt(a); }
double sine(double a) { return std::sin(a); }
double cosine(double a) { return std::cos(a); }
double exponential(double a) { return std::exp(a); }
double logarithm(double a) { return std::log(a); }
double power(double a, int n) { return n < 0 ? 1 / wholePower(a, -n) : wholePower(a, n); }
double power(double a, double exponent) { return std::pow(a, exponent); }
double lifted(double x, double) { return x; }

Interval lifted(double x, const Interval&) { return Interval(x); }

// ---- arithmetic of values with their derivative along a line

Slope lifted(double x, const Slope&) { return {Interval(x), Interval(0)}; }
Slope operator-(const Slope& a) { return {-a.value, -a.slope}; }
Slope operator+(const Slope& a, const Slope& b) { return {a.value + b.value, a.slope + b.slope}; }
Slope operator-(const Slope& a, const Slope& b) { return {a.value - b.value, a.slope - b.slope}; }
Slope operator*(const Slope& a, const Slope& b) {
  return {a.value * b.value, a.value * b.slope + a.slope * b.value};
}
Slope operator/(const Slope& a, const Slope& b) {
  const Interval inverse = reciprocal(b.value), quotient = a.value * inverse;
  return {quotient, (a.slope - quotient * b.slope) * inverse};
}
Slope minimum(const Slope& a, const Slope& b) {
  const Interval value = minimum(a.value, b.value);
  return {value, a.value.high <= b.value.low   ? a.slope
                 : b.value.high <= a.value.low ? b.slope
                                               : hull(a.slope, b.slope)};
}
Slope maximum(const Slope& a, const Slope& b) { return -minimum(-a, -b); }
Slope absolute(const Slope& a) {
  return {absolute(a.value), a.value.low >= 0    ? a.slope
                             : a.value.high <= 0 ? -a.slope
                                                 : hull(a.slope, -a.slope)};
}
Slope squareRoot(const Slope& a) {
  const Interval root = squareRoot(a.value);
  if (root.low == 0 && root.high == 0) return {root, Interval(0)}; // a is 0 everywhere
  return {root, a.slope * reciprocal(Interval(2) * root)};
}
Slope sine(const Slope& a) { return {sine(a.value), a.slope * cosine(a.value)}; }
Slope cosine(const Slope& a) { return {cosine(a.value), -(a.slope * sine(a.value))}; }
Slope exponential(const Slope& a) {
  const Interval e = exponential(a.value);
  return {e, a.slope * e};
}
Slope logarithm(const Slope& a) {
  return {logarithm(a.value), a.slope * reciprocal({std::max(a.value.low, 0.0), a.value.high})};
}
template <class N> Slope power(const Slope& a, N exponent) {
  return {power(a.value, exponent), a.slope * (Interval(double(exponent)) * power(a.value, exponent - 1))};
}

// ---- arithmetic of values with their first and second derivatives

Jet lifted(double x, const Jet&) { return {x, Vec3d(0), Mat3d(0)}; }
Jet operator-(const Jet& a) { return {-a.value, -a.gradient, -a.second}; }
Jet operator+(const Jet& a, const Jet& b) {
  return {a.value + b.value, a.gradient + b.gradient, a.second + b.second};
}
Jet operator-(const Jet& a, const Jet& b) { return a + -b; }
Jet operator*(const Jet& a, const Jet& b) {
  return {a.value * b.value, a.value * b.gradient + b.value * a.gradient,
          a.value * b.second + b.value * a.second + glm::outerProduct(a.gradient, b.gradient) +
              glm::outerProduct(b.gradient, a.gradient)};
}
/** A function of a with the given value and derivatives. */
Jet chained(const Jet& a, double value, double first, double second) {
  return {value, first * a.gradient, first * a.second + second * glm::outerProduct(a.gradient, a.gradient)};
}
Jet operator/(const Jet& a, const Jet& b) {
  const double inverse = 1 / b.value;
  return a * chained(b, inverse, -inverse * inverse, 2 * inverse * inverse * inverse);
}
Jet minimum(const Jet& a, const Jet& b) { return a.value < b.value || std::isnan(a.value) ? a : b; }
Jet maximum(const Jet& a, const Jet& b) { return a.value > b.value || std::isnan(a.value) ? a : b; }
Jet absolute(const Jet& a) { return a.value < 0 ? -a : a; }
Jet squareRoot(const Jet& a) {
  const double root = std::sqrt(a.value);
  return chained(a, root, 0.5 / root, -0.25 / (root * a.value));
}
Jet sine(const Jet& a) {
  const double s = std::sin(a.value);
  return chained(a, s, std::cos(a.value), -s);
}
Jet cosine(const Jet& a) {
  const double c = std::cos(a.value);
  return chained(a, c, -std::sin(a.value), -c);
}
Jet exponential(const Jet& a) {
  const double e = std::exp(a.value);
  return chained(a, e, e, e);
}
Jet logarithm(const Jet& a) { return chained(a, std::log(a.value), 1 / a.value, -1 / square(a.value)); }
template <class N> Jet power(const Jet& a, N exponent) {
  const auto n = double(exponent);
  // No division by a, which may be 0.
  const double first = n == 0 ? 0 : n * power(a.value, exponent - 1),
               second = n == 0 || n == 1 ? 0 : n * (n - 1) * power(a.value, exponent - 2);
  return chained(a, power(a.value, exponent), first, second);
}

// ---- interpreter

using Opcode = Expression::Operation;
using Instruction = Expression::Instruction;

/** Result of an instruction on numbers of any kind; `values` are results of earlier ones. */
template <class N> N resultOf(const Instruction& i, const std::array<N, 3>& p, const N* values) {
  const N &a = values[i.a], &b = values[i.b];
  switch (i.operation) {
  case Opcode::CONSTANT:
    return lifted(i.constant, N{});
  case Opcode::X:
    return p[0];
  case Opcode::Y:
    return p[1];
  case Opcode::Z:
    return p[2];
  case Opcode::ADD:
    return a + b;
  case Opcode::SUBTRACT:
    return a - b;
  case Opcode::MULTIPLY:
    return a * b;
  case Opcode::DIVIDE:
    return a / b;
  case Opcode::MINIMUM:
    return minimum(a, b);
  case Opcode::MAXIMUM:
    return maximum(a, b);
  case Opcode::NEGATE:
    return -a;
  case Opcode::ABSOLUTE:
    return absolute(a);
  case Opcode::SQUARE_ROOT:
    return squareRoot(a);
  case Opcode::SINE:
    return sine(a);
  case Opcode::COSINE:
    return cosine(a);
  case Opcode::EXPONENTIAL:
    return exponential(a);
  case Opcode::LOGARITHM:
    return logarithm(a);
  case Opcode::WHOLE_POWER:
    return power(a, static_cast<int>(i.constant));
  case Opcode::REAL_POWER:
    break;
  }
  return power(a, i.constant);
}

template <class N> N run(const std::vector<Instruction>& instructions, const std::array<N, 3>& p) {
  static thread_local std::vector<N> values(Expression::MOST_INSTRUCTIONS);
  for (size_t i = 0; i < instructions.size(); ++i) values[i] = resultOf(instructions[i], p, values.data());
  return values[instructions.size() - 1];
}

// ---- parser

/** A function or an operator of expressions. */
struct NamedFunction {
  const char* name;
  Opcode operation;
  bool takesMany; ///< two arguments or more instead of one
};
constexpr NamedFunction FUNCTIONS[] = {
    {"min", Opcode::MINIMUM, true},       {"max", Opcode::MAXIMUM, true},   {"abs", Opcode::ABSOLUTE, false},
    {"sqrt", Opcode::SQUARE_ROOT, false}, {"sin", Opcode::SINE, false},     {"cos", Opcode::COSINE, false},
    {"exp", Opcode::EXPONENTIAL, false},  {"log", Opcode::LOGARITHM, false}};

constexpr const char* ACCEPTED_NAMES = "x y z pi min max abs sqrt sin cos exp log";

/** Recursive descent. Equal instructions are made once; operations on constants are done at once. */
class ExpressionParser {
 public:
  explicit ExpressionParser(const std::string& text) : text(text) {}

  std::vector<Instruction> parse() {
    const uint32_t last = parseSum();
    if (next() == ')') fail(at, "this parenthesis closes none");
    if (next() == ',') fail(at, "a comma outside of the arguments of a function");
    if (next()) fail(at, "an operator is missing before " + shown(at), "+ - * / ^");
    if (isConstant(last)) fail(0, "the function is constant", "a function of x, y and z");
    return usedBy(last);
  }

 private:
  static constexpr int MOST_LEVELS = 200; ///< of nesting, against overflow of the stack

  [[noreturn]] static void fail(size_t offset, const std::string& message, const std::string& accepted = {}) {
    throw ExpressionError{offset, message, accepted};
  }

  /** Next character that is no blank; 0 at the end. */
  char next() {
    while (at < text.size() && std::string_view(" \t\n\r").find(text[at]) != std::string_view::npos) ++at;
    return at < text.size() ? text[at] : '\0';
  }
  bool take(char c) {
    if (next() != c) return false;
    ++at;
    return true;
  }
  std::string shown(size_t offset) const {
    const char c = text[offset];
    return c > ' ' && c < 0x7f ? "\"" + std::string(1, c) + "\"" : "this character";
  }

  static bool takesTwo(Opcode o) { return o >= Opcode::ADD && o <= Opcode::MAXIMUM; }

  /** The instructions that an instruction needs; it is the last of them. */
  std::vector<Instruction> usedBy(uint32_t last) const {
    std::vector<bool> isUsed(last + 1, false);
    isUsed[last] = true;
    for (uint32_t i = last + 1; i-- > 0;) {
      if (!isUsed[i] || list[i].operation < Opcode::ADD) continue;
      isUsed[list[i].a] = true;
      if (takesTwo(list[i].operation)) isUsed[list[i].b] = true;
    }
    std::vector<Instruction> used;
    std::vector<uint32_t> number(last + 1, 0);
    for (uint32_t i = 0; i <= last; ++i) {
      if (!isUsed[i]) continue;
      number[i] = static_cast<uint32_t>(used.size());
      Instruction copy = list[i];
      copy.a = number[copy.a];
      copy.b = number[copy.b];
      used.push_back(copy);
    }
    return used;
  }

  bool isConstant(uint32_t i) const { return list[i].operation == Opcode::CONSTANT; }

  /** Number of an instruction, a new one unless there is an equal one. `offset` is its place in the text. */
  uint32_t add(const Instruction& wanted, size_t offset) {
    Instruction i = wanted;
    const bool hasOperand = i.operation >= Opcode::ADD, hasTwo = takesTwo(i.operation);
    if (hasOperand && isConstant(i.a) && (!hasTwo || isConstant(i.b))) {
      const double operands[] = {list[i.a].constant, list[hasTwo ? i.b : i.a].constant};
      const Instruction local{i.operation, 0, 1, i.constant};
      i = {Opcode::CONSTANT, 0, 0, resultOf<double>(local, {}, operands)};
      if (!std::isfinite(i.constant)) fail(offset, "the value of this constant is not finite");
    }
    for (uint32_t k = 0; k < list.size(); ++k)
      if (list[k] == i) return k;
    if (list.size() == Expression::MOST_INSTRUCTIONS)
      fail(offset, "the expression is too long",
           "up to " + std::to_string(Expression::MOST_INSTRUCTIONS) + " different operations");
    list.push_back(i);
    return static_cast<uint32_t>(list.size() - 1);
  }
  uint32_t constant(double x, size_t offset) { return add({Opcode::CONSTANT, 0, 0, x}, offset); }

  uint32_t parseSum() {
    uint32_t a = parseProduct();
    for (char c = next(); c == '+' || c == '-'; c = next()) {
      const size_t offset = at++;
      const uint32_t b = parseProduct();
      a = add({c == '+' ? Opcode::ADD : Opcode::SUBTRACT, a, b}, offset);
    }
    return a;
  }

  uint32_t parseProduct() {
    uint32_t a = parseSigned();
    for (char c = next(); c == '*' || c == '/'; c = next()) {
      const size_t offset = at++;
      const uint32_t b = parseSigned();
      // Squares have tighter bounds than products of two ranges.
      const bool isSquare = c == '*' && a == b;
      a = isSquare ? add({Opcode::WHOLE_POWER, a, 0, 2}, offset)
                   : add({c == '*' ? Opcode::MULTIPLY : Opcode::DIVIDE, a, b}, offset);
    }
    return a;
  }

  /** Signs bind less tightly than powers: -x^2 is -(x^2). */
  uint32_t parseSigned() {
    bool isNegative = false;
    size_t offset = at;
    for (char c = next(); c == '+' || c == '-'; c = next()) {
      isNegative ^= c == '-';
      offset = at++;
    }
    const uint32_t a = parsePower();
    return isNegative ? add({Opcode::NEGATE, a}, offset) : a;
  }

  uint32_t parsePower() {
    if (++level > MOST_LEVELS)
      fail(at, "the expression is nested too deeply", "up to " + std::to_string(MOST_LEVELS) + " levels");
    const uint32_t a = parseOperand();
    const size_t offset = at;
    const uint32_t result = take('^') ? powerOf(a, parseSigned(), offset) : a;
    --level;
    return result;
  }

  uint32_t powerOf(uint32_t a, uint32_t exponent, size_t offset) {
    if (!isConstant(exponent)) // a^b = exp(b log(a))
      return add({Opcode::EXPONENTIAL,
                  add({Opcode::MULTIPLY, exponent, add({Opcode::LOGARITHM, a}, offset)}, offset)},
                 offset);
    constexpr double MOST_FACTORS = 64;
    const double n = list[exponent].constant;
    if (n == 0) return constant(1, offset);
    if (n == 1) return a;
    const bool isWhole = n == std::floor(n);
    if (isWhole && std::abs(n) > MOST_FACTORS)
      fail(offset, "the exponent is too large", "integers from -64 to 64, and other numbers");
    return add({isWhole ? Opcode::WHOLE_POWER : Opcode::REAL_POWER, a, 0, n}, offset);
  }

  static bool isDigit(char c) { return c >= '0' && c <= '9'; }
  static bool isLetter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

  uint32_t parseOperand() {
    const char c = next();
    const size_t begin = at;
    if (isDigit(c) || c == '.') return parseNumber();
    if (isLetter(c)) return parseName();
    if (take('(')) {
      const uint32_t inner = parseSum();
      closeParenthesis(begin);
      return inner;
    }
    if (!c) fail(at, text.empty() ? "the expression is empty" : "the expression ends where a value belongs");
    if (std::string_view("+-*/^),").find(c) != std::string_view::npos)
      fail(at, "a value is missing before " + shown(at), "a number, a name or a parenthesis");
    fail(at, shown(at) + " is not allowed in an expression");
  }

  void closeParenthesis(size_t opened) {
    if (take(')')) return;
    if (!next()) fail(opened, "this parenthesis is not closed");
    if (next() == ',') fail(at, "too many arguments");
    fail(at, "an operator is missing before " + shown(at), "+ - * / ^, or a closing parenthesis");
  }

  uint32_t parseNumber() {
    const size_t begin = at;
    double x = 0;
    const auto [stop, error] = std::from_chars(text.data() + at, text.data() + text.size(), x);
    if (error == std::errc::result_out_of_range) fail(begin, "this number is too large or too small");
    if (error != std::errc()) fail(begin, "this is no number");
    at = static_cast<size_t>(stop - text.data());
    if (at < text.size() && text[at] == '.') fail(at, "a second point in a number");
    return constant(x, begin);
  }

  uint32_t parseName() {
    const size_t begin = at;
    while (at < text.size() && (isLetter(text[at]) || isDigit(text[at]))) ++at;
    const std::string name = text.substr(begin, at - begin);
    if (name == "x") return add({Opcode::X}, begin);
    if (name == "y") return add({Opcode::Y}, begin);
    if (name == "z") return add({Opcode::Z}, begin);
    if (name == "pi") return constant(PI_D, begin);
    for (const NamedFunction& f : FUNCTIONS)
      if (name == f.name) return parseArguments(f, begin);
    fail(begin, "\"" + name + "\" is neither a variable nor a function", ACCEPTED_NAMES);
  }

  uint32_t parseArguments(const NamedFunction& f, size_t begin) {
    const std::string usage =
        std::string(f.name) + (f.takesMany ? "(a, b) with two values or more" : "(a) with one value");
    next();
    const size_t opened = at;
    if (!take('(')) fail(begin, "the function has no arguments", usage);
    if (next() == ')') fail(at, "the function has no arguments", usage);
    uint32_t a = parseSum();
    if (!f.takesMany) {
      closeParenthesis(opened);
      return add({f.operation, a}, begin);
    }
    if (next() == ')') fail(at, "the function needs a second argument", usage);
    while (take(',')) a = add({f.operation, a, parseSum()}, begin);
    closeParenthesis(opened);
    return a;
  }

  const std::string& text;
  size_t at = 0;
  int level = 0;
  std::vector<Instruction> list;
};

} // namespace

SourceLocation locationInString(const SourceLocation& string, size_t offset) {
  SourceLocation where = string;
  const std::string line = where.lineText();
  const auto quote = static_cast<size_t>(std::max(where.column, 1) - 1);
  if (quote >= line.size() || line[quote] != '"') return where; // no text
  size_t column = quote + 1;
  for (size_t i = 0; i < offset && column < line.size(); ++i) column += line[column] == '\\' ? 2 : 1;
  where.column = static_cast<int>(column + 1);
  return where;
}

Expression::Expression(const std::string& text) : instructions(ExpressionParser(text).parse()) {}

double Expression::value(const Vec3d& p) const { return run<double>(instructions, {p.x, p.y, p.z}); }

Interval Expression::value(const std::array<Interval, 3>& p) const { return run(instructions, p); }

Slope Expression::slope(const std::array<Slope, 3>& p) const { return run(instructions, p); }

Jet Expression::jet(const Vec3d& p) const {
  std::array<Jet, 3> variables;
  for (int i = 0; i < 3; ++i) {
    variables[size_t(i)].value = p[i];
    variables[size_t(i)].gradient[i] = 1;
  }
  return run(instructions, variables);
}

} // namespace recurse
