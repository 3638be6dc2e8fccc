#pragma once

#include <filesystem>

namespace brim::viewer {

/// Where the built page lies (index.html and its assets): the environment variable BRIM_VIEWER_DIR if it is set, else
/// share/brim/viewer of the installation that the running program is part of, else the source tree's viewer/dist.
/// @throws InputError  that says where it looked and how to build the page
std::filesystem::path find_page_folder();

/// Likewise the script that makes pictures, render.mjs.
std::filesystem::path find_render_script();

}  // namespace brim::viewer
