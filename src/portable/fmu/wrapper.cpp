#include <fmt/format.h>

#include <cctype>

#include "portable/fmu/parts.h"
#include "portable/fmu/texts.h"
#include "portable/program.h"
#include "portable/write_tables.h"

namespace mimbre::portable {
namespace {

std::string upper_case(std::string name) {
  for (char& c : name) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return name;
}

}  // namespace

std::string fmu_wrapper_file(const FmuCode& fmu) { return fmt::format("fmi{}.c", fmu.version); }

std::string fmu_wrapper(const FmuCode& fmu) {
  const std::string &name = fmu.code.name, upper = upper_case(name);
  const std::string fmi = fmt::format("FMI{}", fmu.version);
  std::string s = fmt::format(
      "/* The functions of FMI {0}.0 for co-simulation around {1}.c, made by mimbre. Compile both, C99, as "
      "one shared\n"
      " * library; they need the C library alone. Functions have the names of the standard; "
      "{2}_FUNCTION_PREFIX, or\n"
      " * with {2}_OVERRIDE_FUNCTION_PREFIX the word {2}_ACTUAL_FUNCTION_PREFIX, goes before them where it "
      "is defined. */\n"
      "#include <float.h>\n#include <math.h>\n#include <stdbool.h>\n#include <stddef.h>\n#include "
      "<stdint.h>\n"
      "#include <stdlib.h>\n#include <string.h>\n\n#include \"{1}.h\"\n\n",
      fmu.version, name, fmi);
  s += named(
      fmt::format("#if !defined({0}_OVERRIDE_FUNCTION_PREFIX) && defined({0}_FUNCTION_PREFIX)\n"
                  "#define {0}_ACTUAL_FUNCTION_PREFIX {0}_FUNCTION_PREFIX\n#endif\n"
                  "#define @_FMU_JOIN(a, b) a##b\n#define @_FMU_JOIN_WORDS(a, b) @_FMU_JOIN(a, b)\n"
                  "#ifdef {0}_ACTUAL_FUNCTION_PREFIX\n"
                  "#define @_FMU_NAME(name) @_FMU_JOIN_WORDS({0}_ACTUAL_FUNCTION_PREFIX, name)\n"
                  "#else\n#define @_FMU_NAME(name) name\n#endif\n"
                  "#if defined _WIN32 || defined __CYGWIN__\n#define @_FMU_EXPORT __declspec(dllexport)\n"
                  "#elif defined __GNUC__\n"
                  "#define @_FMU_EXPORT __attribute__((visibility(\"default\")))\n"
                  "#else\n#define @_FMU_EXPORT\n#endif\n\n",
                  fmi),
      name);
  s += named(fmt::format("#define @_FMU_TOKEN \"{}\"\n#define @_FMU_STEP {}_STEP\n#define @_FMU_INPUTS {}\n"
                         "#define @_FMU_OUTPUTS {}\n",
                         fmu.token, upper, fmu.code.inputs.size(), fmu.code.outputs.size()),
             name);
  for (const char* status : {"UNCONVERGED", "NOT_FINITE", "SINGULAR", "DRIFTED"})
    s += fmt::format("#define {0}_FMU_{2} {1}_{2}\n", name, upper, status);
  std::vector<double> least, most, start;
  for (const GeneratedVariable& v : fmu.code.inputs) {
    least.push_back(v.min);
    most.push_back(v.max);
    start.push_back(v.start);
  }
  s +=
      table(name + "_fmu_least", least) + table(name + "_fmu_most", most) + table(name + "_fmu_start", start);
  s += named(fmu.version == 2 ? fmi2_types_text : fmi3_types_text, name);
  s += named(fmu_instance_text, name);
  s += named(fmu.version == 2 ? fmi2_text : fmi3_text, name);
  return s;
}

}  // namespace mimbre::portable
