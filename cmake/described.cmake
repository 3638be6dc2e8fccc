# Completion for shells and manual pages, which the program writes itself; made with everything else, and installed.
if(TARGET brim_cli AND NOT CMAKE_CROSSCOMPILING)
  set(described ${PROJECT_BINARY_DIR}/described)
  add_custom_command(OUTPUT ${described}/made COMMAND ${CMAKE_COMMAND} -D program=$<TARGET_FILE:brim_cli> -D folder=${described}
    -P ${CMAKE_CURRENT_LIST_DIR}/describe.cmake DEPENDS brim_cli ${CMAKE_CURRENT_LIST_DIR}/describe.cmake VERBATIM)
  add_custom_target(brim_described ALL DEPENDS ${described}/made)
  install(FILES ${described}/brim.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME brim OPTIONAL)
  install(FILES ${described}/brim.zsh DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions RENAME _brim OPTIONAL)
  install(FILES ${described}/brim.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d OPTIONAL)
  install(DIRECTORY ${described}/man1 DESTINATION ${CMAKE_INSTALL_MANDIR} OPTIONAL)
endif()
