#pragma once

#include <functional>
#include <iosfwd>
#include <string>

namespace brim {

/// Looks whether `folder` may become a run folder: it must not exist, be empty, or (with force) hold an old run.
/// Touches nothing. @throws InputError
void check_run_folder(const std::string& folder, bool force);

/// Takes the files of a run out of a folder; others stay.
void remove_run_files(const std::string& folder);

/// Writes a file so that it appears whole or not at all. @throws InputError
void write_whole(const std::string& path, const std::string& text);
/// Likewise, of what is written piece by piece.
void write_whole(const std::string& path, const std::function<void(std::ostream&)>& write);

}  // namespace brim
