from fmpy.ssp import simulation

plain, set_plain = simulation.instantiate_fmu, simulation.set_value


def set_value(component, name, value):
    """FMPy sets no text, and takes "false" for true."""
    variable = component.variables[name]
    if variable.type == "String":
        component.fmu.setString([variable.valueReference], [value])
    else:
        set_plain(component, name, {"true": 1, "false": 0}.get(value, value))


def instantiate(component, folder, start, stop=None, given=None):
    """FMPy ignores the parameter sets of an SSP, and gives every input 0 in the first step."""
    sets = [values for binding in component.parameterBindings for values in binding.parameterValues]
    for parameter in (each for values in sets for each in values.parameters):
        parameter.name = f"{component.name}.{parameter.name}"
    plain(component, folder, start, stop, *sets)
    for connector in component.connectors:
        connector.value = simulation.get_value(component, connector.name)


simulation.instantiate_fmu, simulation.set_value = instantiate, set_value
step = 0.1
result = simulation.simulate_ssp("adcs.ssp", stop_time=120, step_size=step)
time, error = result["time"] + step, result["controller.attitude_error"]
