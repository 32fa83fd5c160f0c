# Writes the bytes of INPUT as a C++ source to OUTPUT.
file(READ ${INPUT} bytes HEX)
string(REGEX REPLACE "(................................)" "\\1\n" bytes "${bytes}")
string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
file(WRITE ${OUTPUT} "#include \"fmu/process_bytes.h\"\n
namespace {
constexpr unsigned char bytes[] = {
${bytes}};
}\n
std::span<const unsigned char> mimbre::fmu::process_bytes() { return bytes; }\n")
