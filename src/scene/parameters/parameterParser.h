/** @file
 * Parsing of parameter lists: `"type name" values "type name" values ...`.
 */
#pragma once

#include <string>
#include <vector>

#include "recurse/scene/parameters/parameters.h"
#include "scene/text/tokenStream.h"

namespace recurse::sceneFile {

/** The words that may stand before a parameter's name. */
const std::vector<std::string>& parameterTypeWords();
/** How the values of a parameter with this type word are written; UNKNOWN for a word that is none. */
enum class ValueKind { NUMBERS, STRINGS, BOOLEANS, SPECTRUM, UNKNOWN };
ValueKind valueKindOf(std::string_view typeWord);

/** Splits `"float radius"` into type and name. Throws SceneError. */
void splitDeclaration(const Token& token, std::string& type, std::string& name, ErrorLog& log);

/**
 * Reads parameters up to the first token that is not a string. Errors are reported, and what could be
 * understood is returned; `directory` is the directive's.
 */
std::vector<ParsedParameter> parseParameters(TokenStream& tokens, ErrorLog& log,
                                             const std::string& directory);

/** Reads the values of one parameter whose type is known into `parameter`. */
void parseValues(TokenStream& tokens, ErrorLog& log, ParsedParameter& parameter);

} // namespace recurse::sceneFile
