# CPack asks this program for the packages that libraries are of, where they are another processor's.
set(SHLIBDEPS_EXECUTABLE ${CMAKE_CURRENT_LIST_DIR}/arm64_shlibdeps)
