/** @file
 * Parsing of parameter lists: `"type name" values "type name" values ...`.
 */
#pragma once

#include <string>
#include <vector>

#include "recurse/scene/parameters/parameters.h"
#include "scene/text/tokenStream.h"

namespace recurse::sceneFile {

/** Type words that may precede the name of a parameter. */
const std::vector<std::string>& parameterTypeWords();
/** Notation of the values of a parameter with this type word; UNKNOWN for an unknown word. */
enum class ValueKind { NUMBERS, STRINGS, BOOLEANS, SPECTRUM, UNKNOWN };
ValueKind valueKindOf(std::string_view typeWord);

/** Splits `"float radius"` into type and name. Throws SceneError. */
void splitDeclaration(const Token& token, std::string& type, std::string& name, ErrorLog& log);

/**
 * Parses parameters up to the first token that is not a string. Errors are reported, and the valid parameters
 * are returned; `directory` is the directive's.
 */
std::vector<ParsedParameter> parseParameters(TokenStream& tokens, ErrorLog& log,
                                             const std::string& directory);

/** Parses the values of one parameter of known type into `parameter`. */
void parseValues(TokenStream& tokens, ErrorLog& log, ParsedParameter& parameter);

} // namespace recurse::sceneFile
