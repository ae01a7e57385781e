// Path expressions in the notation of doc-files/notes/path-expressions.md, as pathExpressionParser.cpp reads them, but
// without automata: a word is matched directly. An expression without paths is no error here. A word is a list of
// letters { letter, names }; names are a list, or null where they are not known and any name may be meant.

const LETTERS = "SDVLE", MAX_LENGTH = 4096, MAX_DEPTH = 100, MAX_REPEAT = 1000;

/** Reason why an expression is refused. `column`: of its first wrong character, from 1. */
class ExpressionError extends Error {
  constructor(column, message, accepted) {
    super(`column ${column}: ${message}${accepted ? `; accepted: ${accepted}` : ""}`);
    Object.assign(this, { column, reason: message, accepted });
  }
}

/** Matcher of an expression: ends(word, i) is the set of positions at which a match that begins at i may end. */
class Matcher {
  constructor(ends) {
    this.find = ends;
  }

  ends(word, i) {
    if (this.word !== word) Object.assign(this, { word, known: new Map() });
    if (!this.known.has(i)) this.known.set(i, this.find(word, i));
    return this.known.get(i);
  }

  static letters(accepts) {
    return new Matcher((word, i) => new Set(i < word.length && accepts(word[i]) ? [i + 1] : []));
  }
  static then(parts) {
    return new Matcher((word, i) => parts.reduce((starts, part) => afterAll(part, word, starts), new Set([i])));
  }
  static either(parts) {
    return new Matcher((word, i) => new Set(parts.flatMap((part) => [...part.ends(word, i)])));
  }
  static repeated(part, least, most) {
    return new Matcher((word, i) => {
      let now = new Set([i]);
      for (let k = 0; k < least && now.size > 0; ++k) now = afterAll(part, word, now);
      const all = new Set(now);
      for (let k = least; k < most && now.size > 0; ++k) {
        now = new Set([...afterAll(part, word, now)].filter((end) => !all.has(end)));
        for (const end of now) all.add(end);
      }
      return all;
    });
  }
  static both(a, b) {
    return new Matcher((word, i) => new Set([...a.ends(word, i)].filter((end) => b.ends(word, i).has(end))));
  }
  static without(a, b) {
    return new Matcher((word, i) => new Set([...a.ends(word, i)].filter((end) => !b.ends(word, i).has(end))));
  }
  /** All paths L(S|D|V)*E. */
  static paths() {
    const one = (letters) => Matcher.letters((l) => letters.includes(l.letter));
    return Matcher.then([one("L"), Matcher.repeated(one("SDV"), 0, Infinity), one("E")]);
  }
}

function afterAll(part, word, starts) {
  const out = new Set();
  for (const start of starts) for (const end of part.ends(word, start)) out.add(end);
  return out;
}

/** Recursive descent. Parts are { matcher, at, whole }; a whole part stands for whole paths, as a named class does. */
class ExpressionParser {
  /** `known`: names { lights, surfaces }, lists or null for any, and `classes`, a list of { name, expression }. */
  constructor(text, known) {
    Object.assign(this, { text, known, position: 0, depth: 0 });
  }

  parse() {
    if (this.text.length > MAX_LENGTH) this.fail(MAX_LENGTH, `an expression has at most ${MAX_LENGTH} characters`);
    const { matcher } = this.alternatives();
    this.skipSpaces();
    if (!this.atEnd()) this.unexpected();
    return Matcher.both(Matcher.paths(), matcher);
  }

  fail(at, message, accepted = "") {
    throw new ExpressionError([...this.text.slice(0, at)].length + 1, message, accepted);
  }

  unexpected() {
    const at = this.position;
    if (this.atEnd())
      this.fail(at, "the expression ends too early", "a letter L S D V E, '.', '[', '(', '!' or a named class");
    const c = String.fromCodePoint(this.text.codePointAt(at));
    if (")]".includes(c))
      this.fail(at, `'${c}' has no matching bracket, or an empty expression before it`, "an expression before it");
    if ("*+?{".includes(c)) this.fail(at, `'${c}' has nothing to repeat`, "a letter, group or bracket before it");
    if (c === "!")
      this.fail(at, "'!' is the complement among whole paths and cannot be part of a path",
        "'!' before a whole class; [^S] for an event that is not S");
    if ("^$".includes(c))
      this.fail(at, `'${c}' is not needed: an expression always stands for whole paths`, "[^S] for an event that is not S");
    if (c === "}") this.fail(at, "'}' without '{'", "A{2}, A{2,} or A{2,3}");
    if ("|&-".includes(c))
      this.fail(at, `'${c}' has nothing on one side`, "an expression on both sides; A? for nothing or A");
    if (c === "'") this.fail(at, "a name has no letter before it", "L'lamp' for lights, D'floor' and S'glass' for surfaces");
    if (/[A-Z]/.test(c))
      this.fail(at, `'${c}' is no path letter`,
        "L light, S specular, D diffuse or glossy, V scattering in a medium, E camera (eye)");
    this.fail(at, `'${c}' has no meaning here`,
      "letters L S D V E, '.', [SD], [^S], (A|B), [A|B], A? A* A+ A{2,3}, A & B, A - B, !A, named classes");
  }

  atEnd() { return this.position >= this.text.length; }
  skipSpaces() { while (!this.atEnd() && " \t\n\r".includes(this.text[this.position])) ++this.position; }
  /** Next character; empty at the end. */
  peek() {
    this.skipSpaces();
    return this.text[this.position] ?? "";
  }
  take(c) {
    if (this.peek() !== c) return false;
    ++this.position;
    return true;
  }

  alternatives() {
    const parts = [], before = this.subtracts;
    this.subtracts = false;
    parts.push(this.intersections());
    while (this.peek() === "|") {
      const bar = this.position++;
      parts.push(this.intersections());
      if (this.subtracts) this.fail(bar, "'-' and '|' side by side can be read in two ways", "(A - B) | C or A - (B | C)");
    }
    this.subtracts = before;
    this.hasBar = parts.length > 1;
    if (parts.length === 1) return parts[0];
    return { matcher: Matcher.either(parts.map((p) => p.matcher)), at: parts[0].at, whole: parts.some((p) => p.whole) };
  }

  intersections() {
    let left = this.complement();
    for (let c = this.peek(); c === "&" || c === "-"; c = this.peek()) {
      ++this.position;
      this.subtracts = this.subtracts || c === "-";
      const right = this.complement();
      left = { matcher: (c === "&" ? Matcher.both : Matcher.without)(left.matcher, right.matcher), at: left.at,
        whole: left.whole || right.whole };
    }
    return left;
  }

  complement() {
    this.skipSpaces();
    const at = this.position;
    let count = 0;
    while (this.take("!")) ++count;
    const part = this.sequence();
    if (count === 0) return part;
    const combine = count % 2 === 1 ? Matcher.without : Matcher.both;
    return { matcher: combine(Matcher.paths(), part.matcher), at, whole: true };
  }

  sequence() {
    const parts = [];
    for (let c = this.peek(); c !== "" && !"|&-)]".includes(c); c = this.peek()) {
      parts.push(this.repeated());
      const whole = parts.length > 1 && parts.find((part) => part.whole);
      if (whole)
        this.fail(whole.at, "this stands for whole paths, from L to E, and cannot be part of a longer one",
          "classes joined by |, & or -");
    }
    if (parts.length === 0) this.unexpected();
    if (parts.length === 1) return parts[0];
    return { matcher: Matcher.then(parts.map((p) => p.matcher)), at: parts[0].at, whole: false };
  }

  repeated() {
    const part = this.atom(), c = this.peek(), at = this.position;
    if (c === "" || !"?*+{".includes(c)) return part;
    ++this.position;
    if (part.whole)
      this.fail(part.at, "this stands for whole paths, from L to E, and cannot be repeated", "classes joined by |, & or -");
    let least = c === "+" ? 1 : 0, most = c === "?" ? 1 : Infinity;
    if (c === "{") {
      least = most = this.number();
      if (this.take(",")) most = this.peek() === "}" ? Infinity : this.number();
      if (!this.take("}")) this.fail(this.position, "'{' is not closed here", "A{2}, A{2,} or A{2,3}");
      if (most < least) this.fail(at, "the upper bound is below the lower one", "A{2}, A{2,} or A{2,3}");
    }
    const again = this.peek();
    if (again !== "" && "?*+{".includes(again))
      this.fail(this.position, "a repetition of a repetition needs parentheses", `(A${c})...`);
    return { matcher: Matcher.repeated(part.matcher, least, most), at: part.at, whole: false };
  }

  number() {
    this.skipSpaces();
    const at = this.position, digits = /^[0-9]*/.exec(this.text.slice(at))[0];
    this.position += digits.length;
    if (digits === "") this.fail(at, "a number is missing", "A{2}, A{2,} or A{2,3}");
    if (Number(digits) > MAX_REPEAT) this.fail(at, `a repetition count is at most ${MAX_REPEAT}`);
    return Number(digits);
  }

  atom() {
    const c = this.peek(), at = this.position;
    if (c !== "" && LETTERS.includes(c)) return { matcher: Matcher.letters(this.letter()), at, whole: false };
    if (/^[a-z]$/.test(c)) return this.namedClass();
    if (this.take(".")) return { matcher: Matcher.letters((l) => "SDV".includes(l.letter)), at, whole: false };
    if (this.take("(")) return this.group(at, ")");
    if (this.take("[")) return this.letterSet(at) ?? this.group(at, "]");
    return this.unexpected();
  }

  /** Parses a letter, with a name or without: whether a letter of a word is one of these. */
  letter() {
    const base = this.text[this.position++];
    if (this.peek() !== "'") return (l) => l.letter === base;
    const at = this.position, name = this.quoted();
    if (name === null) this.fail(at, "this name has no end", "L'lamp', with '' for a ' in it");
    if ("VE".includes(base)) this.fail(at, "V and E have no names", "L'lamp' for lights, D'floor' and S'glass' for surfaces");
    this.checkName(at, name, base === "L");
    return (l) => l.letter === base && (l.names === null || l.names.includes(name));
  }

  /** Reads a quoted name, '' being a quote in it; null if its end is missing. */
  quoted() {
    const found = /^'((?:[^']|'')*)'/.exec(this.text.slice(this.position));
    if (!found) return null;
    this.position += found[0].length;
    return found[1].replaceAll("''", "'");
  }

  checkName(at, name, isLight) {
    const MOST = 8, quoted = (n) => `'${n.replaceAll("'", "''")}'`;
    const [names, others] = isLight ? [this.known.lights, this.known.surfaces] : [this.known.surfaces, this.known.lights];
    if (!names || names.includes(name)) return;
    const kind = isLight ? "light" : "surface", isOther = others?.includes(name);
    const other = isOther ? `: it is a ${isLight ? "surface" : "light"}` : "";
    this.fail(at, `the scene has no ${kind} named ${quoted(name)}${other}`, names.length === 0
      ? `no name: the scene has none for ${kind}s`
      : names.slice(0, MOST).map(quoted).join(", ") + (names.length > MOST ? ", ..." : ""));
  }

  group(at, close) {
    if (++this.depth > MAX_DEPTH) this.fail(at, `groups are nested more than ${MAX_DEPTH} deep`);
    const part = this.alternatives(), { hasBar } = this;
    if (!this.take(close)) {
      if (!this.atEnd()) this.unexpected();
      this.fail(at, `this has no matching '${close}'`);
    }
    if (close === "]" && !hasBar)
      this.fail(at, "brackets hold letters only, or alternatives with a bar", "[SD], [^S], [LS+|LD] or parentheses");
    --this.depth;
    return { ...part, at };
  }

  /** Parses [SD] and [^S] after the bracket; for a group it returns null and leaves the position. */
  letterSet(at) {
    const begin = this.position, isNegated = this.take("^"), tests = [];
    const isLetter = (c) => c !== "" && LETTERS.includes(c);
    const bases = [];
    while (isLetter(this.peek())) {
      const base = this.peek(), test = this.letter();
      tests.push(test);
      if (this.text[this.position - 1] !== "'") bases.push(base); // all letters of this kind
    }
    const contains = (l) => tests.some((test) => test(l));
    if (this.peek() === "]") {
      if (tests.length === 0) this.fail(at, "these brackets hold no letter", "[SD], [^S] or [A|B]");
      ++this.position;
      if (!isNegated) return { matcher: Matcher.letters(contains), at, whole: false };
      if ("SDV".split("").every((base) => bases.includes(base)))
        this.fail(at, "this leaves none of S, D and V", "[SD], [^S] or [A|B]");
      return { matcher: Matcher.letters((l) => "SDV".includes(l.letter) && (l.names === null && !bases.includes(l.letter)
        || !contains(l))), at, whole: false };
    }
    if (isNegated) {
      if (this.atEnd()) this.fail(at, "this has no matching ']'");
      this.fail(this.position, "after [^ there are only letters", "[^S] or [^SD]");
    }
    this.position = begin;
    return null;
  }

  namedClass() {
    const at = this.position, name = /^[a-z]+/.exec(this.text.slice(at))[0];
    this.position += name.length;
    const found = this.known.classes.find((c) => c.name === name);
    if (found) return { matcher: new ExpressionParser(found.expression, this.known).parse(), at, whole: true };
    return this.fail(at, `there is no class '${name}'${/^[sdvle]+$/.test(name) ? "; path letters are upper case" : ""}`,
      `letters L S D V E, or ${this.known.classes.map((c) => c.name).join(", ")}`);
  }
}

/** Set of paths: contains(word). Throws ExpressionError. */
class PathExpression {
  constructor(text, known) {
    this.matcher = new ExpressionParser(text, known).parse();
  }

  contains(word) { return this.matcher.ends(word, 0).has(word.length); }
}

/** Word of a text such as LSDE or L'lamp'D'floor+wood'E; letters without names have none. */
function wordOf(text) {
  return [...text.matchAll(/([LSDVE])(?:'((?:[^']|'')*)')?/g)].map(([, letter, names]) => ({ letter,
    names: names === undefined ? [] : names.replaceAll("''", "'").split("+") }));
}
