# Clang and LLD of the package of Zig (MIMBRE_COMPILER, scripts/wasm-compiler), with the headers and libraries of emscripten
# (MIMBRE_SYSROOT): those of Zig have no exceptions, and Debian's emscripten has an old compiler. Its own driver,
# emcc, does not take another compiler.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR wasm32)
set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES MIMBRE_COMPILER MIMBRE_SYSROOT)
set(CMAKE_CXX_COMPILER ${MIMBRE_COMPILER} clang --driver-mode=g++ -target wasm32-unknown-emscripten)
set(CMAKE_CXX_COMPILER_WORKS ON)
get_filename_component(compiler_folder ${MIMBRE_COMPILER} DIRECTORY)
# As emcc: the ABI of its libraries, and the headers of the compiler behind them.
set(CMAKE_CXX_FLAGS_INIT "--sysroot=${MIMBRE_SYSROOT} -Xclang -iwithsysroot/include/compat -idirafter${compiler_folder}/lib/include -D_LIBCPP_ABI_VERSION=2 -D__EMSCRIPTEN_major__=3 -D__EMSCRIPTEN_minor__=1 -D__EMSCRIPTEN_tiny__=6 -fno-threadsafe-statics -fvisibility=default")
set(libraries ${MIMBRE_SYSROOT}/lib/wasm32-emscripten)
# _initialize runs the constructors. A symbol that no library has is an error, except for the one that the page provides
# (web/src/pageSolver.ts).
set(CMAKE_CXX_LINK_EXECUTABLE "${MIMBRE_COMPILER} wasm-ld -o <TARGET> ${libraries}/crt1_reactor.o <OBJECTS> -L${libraries} -lstandalonewasm-memgrow -lstubs -lnoexit -lc -ldlmalloc -lcompiler_rt -lc++-except -lc++abi-except -lunwind-except --entry=_initialize --allow-undefined-file=${CMAKE_CURRENT_LIST_DIR}/imports.txt <LINK_FLAGS>")
