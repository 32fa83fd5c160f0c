#include "portable/code_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

#include "mimbre/diagnostics.h"
#include "portable/dependencies.h"
#include "portable/program.h"
#include "portable/write_tables.h"

namespace mimbre::portable {
namespace {

/// What the headers declare that the code includes: functions, types and macros of C99, and what compilers
/// know or declare beside it.
bool is_of_library(const std::string& name) {
  // Of <math.h>, also with f and l behind them.
  static const std::set<std::string> of_math{
      "acos",      "acosh",       "asin",       "asinh", "atan",      "atan2",  "atanh",   "cbrt",
      "ceil",      "copysign",    "cos",        "cosh",  "erf",       "erfc",   "exp",     "exp2",
      "expm1",     "fabs",        "fdim",       "floor", "fma",       "fmax",   "fmin",    "fmod",
      "frexp",     "hypot",       "ilogb",      "ldexp", "lgamma",    "llrint", "llround", "log",
      "log10",     "log1p",       "log2",       "logb",  "lrint",     "lround", "modf",    "nan",
      "nearbyint", "nextafter",   "nexttoward", "pow",   "remainder", "remquo", "rint",    "round",
      "scalbln",   "scalbn",      "sin",        "sinh",  "sqrt",      "tan",    "tanh",    "tgamma",
      "trunc",     "drem",        "exp10",      "gamma", "j0",        "j1",     "jn",      "pow10",
      "scalb",     "significand", "sincos",     "y0",    "y1",        "yn",     "finite"};
  static const std::set<std::string> others{
      "double_t",    "float_t",   "fpclassify",  "isfinite",      "isgreater",   "isgreaterequal",
      "isinf",       "isless",    "islessequal", "islessgreater", "isnan",       "isnormal",
      "isunordered", "signbit",   "signgam",     "HUGE_VAL",      "HUGE_VALF",   "HUGE_VALL",
      "INFINITY",    "NAN",       "NULL",        "bool",          "true",        "false",
      "offsetof",    "ptrdiff_t", "size_t",      "wchar_t",       "max_align_t", "bcmp",
      "bcopy",       "bzero",     "ffs",         "ffsl",          "ffsll",       "index",
      "rindex",      "memchr",    "memcmp",      "memcpy",        "memmove",     "memset",
      "memccpy",     "mempcpy",   "strcat",      "strchr",        "strcmp",      "strcoll",
      "strcpy",      "strcspn",   "strerror",    "strlen",        "strncat",     "strncmp",
      "strncpy",     "strpbrk",   "strrchr",     "strspn",        "strstr",      "strtok",
      "strxfrm",     "strdup",    "strndup",     "strsep",        "strsignal",   "stpcpy",
      "stpncpy",     "strnlen",   "strcasecmp",  "strncasecmp",   "abort",       "abs",
      "atexit",      "atof",      "atoi",        "atol",          "atoll",       "bsearch",
      "calloc",      "div",       "div_t",       "exit",          "free",        "getenv",
      "labs",        "ldiv",      "ldiv_t",      "llabs",         "lldiv",       "lldiv_t",
      "malloc",      "mblen",     "mbstowcs",    "mbtowc",        "qsort",       "rand",
      "random",      "realloc",   "srand",       "srandom",       "strtod",      "strtof",
      "strtol",      "strtold",   "strtoll",     "strtoul",       "strtoull",    "system",
      "wcstombs",    "wctomb",    "alloca",      "main",          "printf",      "linux",
      "unix",        "asm",       "typeof"};
  const auto known = [&](const std::string& one) { return of_math.contains(one); };
  const bool ends = name.ends_with('f') || name.ends_with('l');
  return known(name) || (ends && known(name.substr(0, name.size() - 1))) || others.contains(name);
}

}  // namespace

std::string identifier(const std::string& text) {
  std::string out;
  for (const char c : text) out += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  if (out.empty() || std::isdigit(static_cast<unsigned char>(out[0]))) out = "m" + out;
  return out;
}

void check_identifier(const std::string& name) {
  // The words of C99 that a model may be called; what it declares would not compile.
  static const std::set<std::string> words{
      "auto",   "break",    "case",     "char",     "const", "continue", "default", "do",     "double",
      "else",   "enum",     "extern",   "float",    "for",   "goto",     "if",      "inline", "int",
      "long",   "register", "restrict", "return",   "short", "signed",   "sizeof",  "static", "struct",
      "switch", "typedef",  "union",    "unsigned", "void",  "volatile", "while"};
  if (words.contains(name))
    throw InputError(Mark{}, fmt::format("the name '{}' is a word of C: take another one", name));
  if (!name.empty() && !std::isdigit(static_cast<unsigned char>(name[0])) &&
      std::all_of(name.begin(), name.end(),
                  [](unsigned char c) { return c < 0x80 && (std::isalnum(c) || c == '_'); }))
    return;
  throw InputError(Mark{},
                   fmt::format("the name '{}' is no identifier of C: take letters from a to z and A to Z, "
                               "digits and _, and begin with a letter",
                               name));
}

void check_type_name(const std::string& name) {
  check_identifier(name);
  if (is_of_library(name))
    throw InputError(Mark{},
                     fmt::format("the name '{}' is taken by the library of C: take another one", name));
}

std::string upper_case(std::string name) {
  for (char& c : name) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return name;
}

std::string comment(std::string text) {
  for (std::size_t at = 0; (at = text.find("*/", at)) != std::string::npos;) text.replace(at, 2, "* /");
  return text;
}

void name_variables(const Compiled& m, const State& start, const RecordedModel& recorded,
                    GeneratedCode& out) {
  std::set<std::string> used;
  const auto unique = [&](const std::string& name) {
    std::string one = upper_case(identifier(name));
    while (!used.insert(one).second) one += "_";
    return one;
  };
  for (const spec::Input& i : m.spec().inputs) {
    GeneratedVariable v{i.name, unique("in_" + i.name), i.unit, "", 0, i.min, i.max, i.tunable};
    for (const SignalsData::HeldInput& h : m.signals.held)
      if (h.input == static_cast<int>(out.inputs.size())) v.start = start.u[h.held];
    out.inputs.push_back(v);
  }
  const std::vector<Dependencies> dependencies = dependencies_of_outputs(recorded, m.signals);
  for (const RecordedOutput& o : recorded.outputs) {
    const std::size_t k = out.outputs.size();
    out.outputs.push_back({o.name, unique("out_" + o.name), o.unit, o.meaning});
    out.outputs.back().inputs = dependencies[k].inputs;
    out.outputs.back().by_time = dependencies[k].time;
    out.outputs.back().by_state = dependencies[k].motion || dependencies[k].memory;
    out.outputs.back().by_acceleration = dependencies[k].acceleration;
  }
}

std::string variable_names(const GeneratedCode& code) {
  const std::string upper = upper_case(code.name);
  std::string h = "/* Inputs and tunable parameters. */\n";
  for (std::size_t k = 0; k < code.inputs.size(); ++k) {
    const GeneratedVariable& v = code.inputs[k];
    std::string range;
    if (std::isfinite(v.min) || std::isfinite(v.max)) range = fmt::format(", from {} to {}", v.min, v.max);
    h += fmt::format("#define {}_{} {} /* {}{}{}, starts at {}{} */\n", upper, v.identifier, k,
                     v.tunable ? "parameter " : "", comment(v.name),
                     v.unit.empty() ? "" : ", " + comment(v.unit), v.start, range);
  }
  h += "\n/* Outputs. */\n";
  for (std::size_t k = 0; k < code.outputs.size(); ++k) {
    const GeneratedVariable& v = code.outputs[k];
    h += fmt::format("#define {}_{} {} /* {}, {}: {} */\n", upper, v.identifier, k, comment(v.name),
                     comment(v.unit), comment(v.meaning));
  }
  return h;
}

namespace {

/// A string of C.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text)
    if (c == '"' || c == '\\' || c == '?')  // ??x may be another character
      out += std::string("\\") + c;
    else
      out += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  return out + '"';
}

}  // namespace

std::string variable_lists(const GeneratedCode& code) {
  std::string h = "\n/* Their names and units, each with a comma behind it. */\n";
  const auto list = [&](const char* word, const std::vector<GeneratedVariable>& variables,
                        std::string GeneratedVariable::*text) {
    h += fmt::format("#define {}_{}", upper_case(code.name), word);
    for (const GeneratedVariable& v : variables) h += " \\\n  " + quoted(v.*text) + ",";
    h += "\n";
  };
  list("INPUT_NAMES", code.inputs, &GeneratedVariable::name);
  list("INPUT_UNITS", code.inputs, &GeneratedVariable::unit);
  list("OUTPUT_NAMES", code.outputs, &GeneratedVariable::name);
  list("OUTPUT_UNITS", code.outputs, &GeneratedVariable::unit);
  return h;
}

std::string held_inputs(const Compiled& m, const GeneratedCode& code) {
  if (code.inputs.empty()) return "";
  std::string s = named(
      "typedef struct {\n  int held, linear;\n  double least, most;\n} @_held_input;\nstatic const "
      "@_held_input @_held_inputs[] = {\n",
      code.name);
  for (std::size_t k = 0; k < code.inputs.size(); ++k)
    for (const SignalsData::HeldInput& h : m.signals.held)
      if (h.input == static_cast<int>(k))
        s += fmt::format("  {{{}, {}, {}, {}}},\n", h.held, h.linear ? 1 : 0, literal(code.inputs[k].min),
                         literal(code.inputs[k].max));
  return s + "};\n";
}

void StructText::add(const std::string& member, long count, const std::string& about) {
  const long size = std::max(count, 1L);
  doubles += size;
  text += fmt::format("  double {}[{}];{}\n", member, size, about.empty() ? "" : " /* " + about + " */");
}

void StructText::add_ints(const std::string& member, long count) {
  const long size = std::max(count, 1L);
  ints += size;
  text += fmt::format("  int {}[{}];\n", member, size);
}

}  // namespace mimbre::portable
