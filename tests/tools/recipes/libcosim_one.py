from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave

log_output_level(CosimLogLevel.ERROR)
execution = CosimExecution.from_step_size(100_000_000)  # ns
plant = execution.add_local_slave(CosimLocalSlave(fmu_path="plant.fmu", instance_name="plant"))
references = {v.name.decode(): v.reference for v in execution.slave_variables(plant)}
for name, value in {"omega_B0[1]": 0.04, "omega_B0[2]": -0.0789, "omega_B0[3]": 0.04}.items():
    execution.real_initial_value(plant, references[name], value)
observer = CosimObserver.create_last_value()
execution.add_observer(observer)
time, rate = [], []
for k in range(600):
    execution.step()
    time.append((k + 1) * 0.1)
    rate += observer.last_real_values(plant, [references["omega_B[2]"]])
