#pragma once

/// Parts of an FMU's C99 that are the same for every model, with '@' for its name.
namespace mimbre::portable {

extern const char* const fmu_instance_text;  ///< an instance, its checks and its steps: no name of FMI in it
extern const char* const fmi2_types_text;    ///< what the public standard FMI 2.0 declares
extern const char* const fmi2_text;          ///< its functions
extern const char* const fmi3_types_text;    ///< the same of FMI 3.0
extern const char* const fmi3_text;

}  // namespace mimbre::portable
