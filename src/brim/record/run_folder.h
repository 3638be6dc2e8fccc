#pragma once

#include <functional>
#include <iosfwd>
#include <string>

namespace brim {

/// Checks that `folder` can become a run folder: it must not exist, be empty, or (with force) contain an old run.
/// Changes nothing. @throws InputError
void check_run_folder(const std::string& folder, bool force);

/// Removes the files of a run from a folder; others stay.
void remove_run_files(const std::string& folder);

/// Writes a file atomically. @throws InputError
void write_whole(const std::string& path, const std::string& text);
/// The same for text written piece by piece.
void write_whole(const std::string& path, const std::function<void(std::ostream&)>& write);

}  // namespace brim
