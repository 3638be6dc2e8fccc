# Packages of the installed tree: cpack --config build/release/CPackConfig.cmake makes brim-VERSION.tar.gz, which runs from wherever
# it is unpacked, and a .deb.
set(CPACK_GENERATOR TGZ DEB)
set(CPACK_PACKAGE_NAME brim)
set(CPACK_PACKAGE_VENDOR brim)
set(CPACK_PACKAGE_CONTACT "the brim authors <brim@localhost>")
set(CPACK_PACKAGE_FILE_NAME brim-${PROJECT_VERSION}-${CMAKE_SYSTEM_NAME}-${CMAKE_SYSTEM_PROCESSOR})
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_STRIP_FILES ON)
set(CPACK_THREADS 1)
set(CPACK_OUTPUT_FILE_PREFIX ${PROJECT_BINARY_DIR}/packages)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)  # asks dpkg-shlibdeps which packages hold the libraries that are linked
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "python3-numpy, nodejs")
# What a program that links the static library needs; tools/check_packages.sh builds one from them on a bare system.
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "libeigen3-dev, libfmt-dev, libassimp-dev, libhdf5-dev, libtinyxml2-dev, zlib1g-dev")
if(BRIM_HAS_OPENVDB)
  string(APPEND CPACK_DEBIAN_PACKAGE_SUGGESTS ", libopenvdb-dev")
endif()
if(BRIM_HAS_GDCM)
  string(APPEND CPACK_DEBIAN_PACKAGE_SUGGESTS ", libgdcm-dev")
endif()
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "simulator of bodies of any kind in contact
 Rigid and articulated bodies, elastic solids, cloth, rods, grains, fluids and
 volumes of voxels touch each other through a grid of densities. The program
 brim, its viewer, the C++ library and the Python module.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
# Debian's own Python looks in /usr/lib/python3/dist-packages.
if(BRIM_PYTHON)
  install(CODE "if(\"\${CMAKE_INSTALL_PREFIX}\" STREQUAL \"/usr\" AND NOT \"${BRIM_PYTHON_INSTALL_DIR}\" STREQUAL \"lib/python3/dist-packages\")
    set(root \"\$ENV{DESTDIR}/usr/lib/python3/dist-packages\")
    file(MAKE_DIRECTORY \${root})
    file(RENAME \"\$ENV{DESTDIR}/usr/${BRIM_PYTHON_INSTALL_DIR}/brim\" \${root}/brim)
  endif()")
endif()
include(CPack)
