#include <fmt/format.h>

#include <algorithm>

#include "portable/code_parts.h"
#include "portable/constants.h"
#include "portable/fmu/parts.h"
#include "portable/fmu/texts.h"
#include "portable/program.h"
#include "portable/write_tables.h"

namespace mimbre::portable {

namespace {

/// By the number of an output of the code: how many elements the variable has whose reference it is (0: there
/// is none), and which outputs these are, in rows of the longest one.
struct Arrays {
  explicit Arrays(const FmuCode& fmu) {
    const std::size_t first = 1 + fmu.code.inputs.size(), outputs = fmu.code.outputs.size();
    for (const FmuVariable& v : fmu.variables)
      longest = std::max(longest, static_cast<int>(v.outputs.size()));
    sizes.resize(outputs);
    elements.resize(outputs * static_cast<std::size_t>(longest));
    for (const FmuVariable& v : fmu.variables) {
      if (v.outputs.empty()) continue;
      const std::size_t at = v.reference - first;
      sizes[at] = static_cast<int>(v.outputs.size());
      std::copy(v.outputs.begin(), v.outputs.end(),
                elements.begin() + static_cast<std::ptrdiff_t>(at) * longest);
    }
  }
  int longest = 1;
  std::vector<int> sizes, elements;
};

}  // namespace

std::string fmu_wrapper_file(const FmuCode& fmu) { return fmt::format("fmi{}.c", fmu.version); }

std::string fmu_wrapper(const FmuCode& fmu) {
  const std::string &name = fmu.code.name, upper = upper_case(name);
  const bool exchange = fmu.kind == FmuOptions::Kind::model_exchange;
  const std::string fmi = fmt::format("FMI{}", fmu.version);
  std::string s = fmt::format(
      "/* The functions of FMI {0}.0 for {3} around {1}.c, made by mimbre. Compile both, C99, as "
      "one shared\n"
      " * library; they need the C library alone. Functions have the names of the standard; "
      "{2}_FUNCTION_PREFIX, or\n"
      " * with {2}_OVERRIDE_FUNCTION_PREFIX the word {2}_ACTUAL_FUNCTION_PREFIX, goes before them where it "
      "is defined. */\n"
      "#include <float.h>\n#include <math.h>\n#include <stdbool.h>\n#include <stddef.h>\n#include "
      "<stdint.h>\n"
      "#include <stdlib.h>\n#include <string.h>\n\n#include \"{1}.h\"\n\n",
      fmu.version, name, fmi, exchange ? "model exchange" : "co-simulation");
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
  const Constants define(s, name + "_FMU");
  define.text("TOKEN", '"' + fmu.token + '"');
  define("INPUTS", std::ssize(fmu.code.inputs));
  define("OUTPUTS", std::ssize(fmu.code.outputs));
  const auto whole = std::count_if(fmu.code.parameters.begin(), fmu.code.parameters.end(),
                                   [](const GeneratedParameter& p) { return p.integer; });
  define("PARAMETERS", std::ssize(fmu.code.parameters) - whole);
  define("WHOLE_PARAMETERS", whole);
  define("LIBRARY", fmu.with_library ? 1L : 0L);
  define("VARIES", long{fmu.code.varies});
  const Arrays arrays(fmu);
  define("ARRAYS", arrays.longest > 1 ? 1L : 0L);
  define("LONGEST", long{arrays.longest});
  if (exchange) {
    define("STATES", std::ssize(fmu.code.states));
    define("INDICATORS", long{fmu.code.indicators});
    define("INDICATOR_VARIABLES", fmu.version == 2 ? 0L : long{fmu.code.indicators});
    define.text("MODEL_OK", upper + "_OK");
  } else {
    define.text("STEP", upper + "_STEP");
    define.text("UNCONVERGED", (fmu.with_library ? name : upper) + "_UNCONVERGED");
    define.text("ENDED", (fmu.with_library ? name : upper) + "_ENDED");
  }
  if (!exchange) define("EVENT_MODE", fmu.version == 3 && fmu.code.events > 0 ? 1L : 0L);
  if (fmu.version == 2) define.text("KIND", exchange ? "fmi2ModelExchange" : "fmi2CoSimulation");
  if (!fmu.with_library) define.of_header(name, {"NOT_FINITE", "SINGULAR", "DRIFTED"});
  std::vector<double> least, most, start;
  std::vector<int> tunable;
  for (const GeneratedVariable& v : fmu.code.inputs) {
    least.push_back(v.min);
    most.push_back(v.max);
    start.push_back(v.start);
    tunable.push_back(v.tunable ? 1 : 0);
  }
  s += table(name + "_fmu_least", least) + table(name + "_fmu_most", most) +
       table(name + "_fmu_start", start) + table(name + "_fmu_tunable", tunable);
  if (!exchange) {
    std::vector<int> jumps;
    for (const GeneratedVariable& v : fmu.code.outputs) jumps.push_back(v.name.starts_with("event.") ? 1 : 0);
    s += table(name + "_fmu_jumps", jumps);
  }
  if (arrays.longest > 1)
    s += table(name + "_fmu_sizes", arrays.sizes) + table(name + "_fmu_elements", arrays.elements);
  const bool two = fmu.version == 2;
  for (const char* text :
       {two ? fmi2_types_text : fmi3_types_text, exchange ? fmu_exchange_head_text : fmu_steps_head_text,
        fmu_instance_text, exchange ? fmu_exchange_text : fmu_steps_text, two ? fmi2_text : fmi3_text,
        exchange ? (two ? fmi2_exchange_text : fmi3_exchange_text)
                 : (two ? fmi2_steps_text : fmi3_steps_text)})
    s += named(text, name);
  return s;
}

}  // namespace mimbre::portable
