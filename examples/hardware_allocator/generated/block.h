/* Generated from interface.toml; do not edit. */
#include "actuators.h"

#include "actuators_guard.h"

#define BLOCK_GUID "{a380701c-3188-96dd-d753-d1091510c3e1}"
#define BLOCK_FMI 2
#define BLOCK_DERIVATIVES 0
#define BLOCK_VARIABLES 26u

typedef ActuatorsParameters Parameters;
typedef ActuatorsInputs Inputs;
typedef ActuatorsOutputs Outputs;
typedef ActuatorsState State;
typedef ActuatorsLaw Law;

#define block_check actuators_check
#define block_prepare actuators_prepare
#define block_start actuators_start
#define block_outputs actuators_outputs
#define block_step actuators_step
#ifdef ACTUATORS_GUARDED
#define block_guard(y, f) true
#else
#define block_guard actuators_guard
#endif
#ifdef ACTUATORS_STATE_USED
#define block_state_used ACTUATORS_STATE_USED
#else
#define block_state_used(x) sizeof(State)
#endif
