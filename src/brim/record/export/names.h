#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace brim::exporting {

/// Names of bodies in files, one for each, in their order: no two of them, nor of their frames, are ever the same file.
/// Letters of every script, digits, "_", "-" and "." stay, combining marks go, anything else becomes "_". A number is
/// appended to what would otherwise be
///   - the name of another body: "a b" beside "a_b"; "ball" beside "Ball" where upper and lower case are one file
///   - a frame of another body: "ball_00001" beside "ball"
/// A name that needs no change keeps itself, and the first of equals. "contacts" is kept for the contacts.
/// Tests: tests/record/export_names_test.cpp
std::vector<std::string> file_names(const std::vector<std::string>& bodies);

/// Identifiers, one for each name, in their order: a letter or "_", then letters of English, digits, "_". Letters of
/// Latin, Greek and Cyrillic become English ones, any other "u" and its number in Unicode.
/// @param taken  identifiers that none may have
std::vector<std::string> identifiers(const std::vector<std::string>& names, std::vector<std::string> taken = {});

}  // namespace brim::exporting
