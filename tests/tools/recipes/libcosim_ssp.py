import zipfile

from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimObserver import CosimObserver

log_output_level(CosimLogLevel.ERROR)
step = 0.1
zipfile.ZipFile("adcs.ssp").extractall("adcs")  # libcosim reads the unpacked archive
execution = CosimExecution.from_ssp_file("adcs", step_size=round(step * 1e9))  # ns
observer = CosimObserver.create_last_value()
execution.add_observer(observer)
controller = execution.slave_index_from_instance_name("controller")
reference = next(v.reference for v in execution.slave_variables(controller) if v.name == b"attitude_error")
time, error = [], []
for k in range(round(120 / step)):
    execution.step()
    time.append((k + 1) * step)
    error += observer.last_real_values(controller, [reference])
