"""A mass on a slide or a hinge: its model, and a map of logs in which its motion drives and its force is compared."""

MODEL = """<mujoco><option timestep="0.005" gravity="0 0 0"/><compiler angle="radian"/><worldbody><body>
<joint name="{kind}" type="{kind}" axis="1 0 0" range="-1 1"/><geom size="0.1" mass="2" pos="0 0 1"/></body></worldbody>
<actuator><motor name="motor" joint="{kind}"/></actuator></mujoco>"""
MAP = """
name = "cart"
model = "cart.xml"
time = "t"
window = 2.0
cutoff = 10.0
[[channel]]
name = "motion"
role = "drive"
joint = "slide"
field = "q"
unit = "m"
[[channel]]
name = "force"
role = "compare"
actuator = "motor"
field = "f"
unit = "N"
"""
