from fmpy import simulate_fmu

result = simulate_fmu(
    "plant.fmu",
    stop_time=60,
    output_interval=0.1,  # the communication step
    start_values={"omega_B0[1]": 0.04, "omega_B0[2]": -0.0789, "omega_B0[3]": 0.04},
    output=["omega_B[1]", "omega_B[2]", "omega_B[3]"],
)
time, rate = result["time"], result["omega_B[2]"]
