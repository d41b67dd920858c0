from fmpy import simulate_fmu

result = simulate_fmu("adcs.fmu", stop_time=120, output_interval=0.1, output=["controller.attitude_error"])
time, error = result["time"], result["controller.attitude_error"]
