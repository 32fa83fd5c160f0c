#pragma once

/// Parts of an FMU's C99 that are the same for every model, with '@' for its name.
namespace mimbre::portable {

extern const char* const fmu_instance_text;  ///< an instance and its checks: no name of FMI in it
extern const char* const fmi2_types_text;    ///< what the public standard FMI 2.0 declares
extern const char* const fmi2_text;          ///< its functions of both kinds
extern const char* const fmi3_types_text;    ///< the same of FMI 3.0
extern const char* const fmi3_text;

// Of co-simulation.
extern const char* const fmu_steps_head_text;  ///< what an instance keeps
extern const char* const fmu_steps_text;       ///< its steps
extern const char* const fmi2_steps_text;
extern const char* const fmi3_steps_text;

// Of model exchange.
extern const char* const fmu_exchange_head_text;
extern const char* const fmu_exchange_text;
extern const char* const fmi2_exchange_text;
extern const char* const fmi3_exchange_text;

}  // namespace mimbre::portable
