#!/usr/bin/env python3
"""Drives the arm in MuJoCo: other physics, other code. Started by blind_generator, not by hand.

    mujoco_cases.py FOLDER

FOLDER/job.json: the robot as built and the ways; FOLDER/commands.bin: commanded joints of each way, every step, 6 doubles. Writes
FOLDER/results.bin: for each step 6 motor angles and the tool point [m]. Angles of the URDF chain [rad].

Of each joint: a motor with armature, held by a position servo with velocity feed-forward; then, where the joint is compliant, the
gear's spring and damper; then, where it has backlash, a gap with soft stops and dry friction on the link's side; then the link.
"""

import json
import os
import sys

import mujoco
import numpy

AXES = ["0 0 1", "0 1 0", "0 -1 0", "-1 0 0", "0 -1 0", "-1 0 0"]
ARMATURE = [1.0, 1.0, 0.8, 0.15, 0.15, 0.05]  # [kg m^2] at the joint
STIFFNESS = [2e5, 2e5, 2e5, 3e4, 3e4, 1e4]  # [Nm/rad] of the servo
OUTPUT = [0.3, 0.3, 0.15, 0.01, 0.01, 0.005]  # [kg m^2] of a gear's output before a gap: else its spring is too quick for the step
INERTIA = [2.0, 2.0, 0.8, 0.06, 0.06, 0.02]  # [kg m^2] of what hangs on a gear, roughly, for its damping
SERVO_DAMPING, GEAR_DAMPING = 0.9, 0.3  # of the critical one
TINY = '<inertial pos="0 0 0" mass="0.001" diaginertia="1e-5 1e-5 1e-5"/>'


def joint(j, robot, inside):
    """The bodies of joint j, motor outermost, around what the link carries."""
    half, compliance = robot["gap_half"][j], robot["compliance"][j]
    axis = numpy.array([float(x) for x in AXES[j].split()])
    turn = 0.5 * robot["zero_offset"][j]
    quaternion = " ".join(repr(float(x)) for x in (numpy.cos(turn), *(numpy.sin(turn) * axis)))
    text = f'<body quat="{quaternion}">{TINY}{inside}</body>'
    if half > 0:
        text = (f'<body>{TINY}<joint name="gap{j}" axis="{AXES[j]}" limited="true" range="{-half!r} {half!r}" '
                f'solreflimit="0.002 1" solimplimit="0.99 0.99 0.001"/>{text}</body>')
    if compliance > 0:
        damping = 2 * GEAR_DAMPING * numpy.sqrt(INERTIA[j] / compliance)
        output = OUTPUT[j] if half > 0 else 0.0
        text = (f'<body>{TINY}<joint name="gear{j}" axis="{AXES[j]}" armature="{output}" stiffness="{1 / compliance!r}" damping="{float(damping)!r}"/>'
                f'{text}</body>')
    return f'{TINY}<joint name="motor{j}" axis="{AXES[j]}" armature="{ARMATURE[j]}"/>{text}'


def mass(kg, x, y, z):
    return f'<inertial pos="{x!r} {y!r} {z!r}" mass="{kg!r}" diaginertia="1e-6 1e-6 1e-6"/>'


def model(robot, payload_kg):
    m, a, d, tool = robot["masses"], robot["a"], robot["d"], robot["tool"]
    # Places of the joints, each in the link before it; a and d are what the rows of the table are too long.
    places = [(0, 0, 0), (0.075 + a[1], 0, 0), (0, 0, 0.300 + a[2]), (0, 0, 0.075 + a[3]), (0.320 + d[3], 0, 0), (0.080, 0, 0)]
    carried = {1: mass(5.5 * m["upper_arm"], 0, 0, 0.15 + m["upper_arm_off"]),
               2: mass(6.0 * m["forearm"], 0.08 + m["forearm_off"], 0, 0.06),
               4: mass(1.2 * m["wrist"], 0.03, 0, 0),
               5: mass(payload_kg, 0.05 + m["payload_off"], 0, 0)}
    # Tool frame in the last link: x up, y to the right, z ahead.
    text = f'<site name="tool" pos="{0.07465 + tool[2]!r} {-tool[1]!r} {tool[0]!r}"/>'
    for j in reversed(range(6)):
        inside = (f"<body>{carried[j]}</body>" if j in carried else "") + text
        text = f'<body pos="{places[j][0]!r} {places[j][1]!r} {places[j][2]!r}">{joint(j, robot, inside)}</body>'
    drives = "".join(f'<position joint="motor{j}" kp="{STIFFNESS[j]}"/>' for j in range(6))
    drives += "".join(
        f'<velocity joint="motor{j}" kv="{2 * SERVO_DAMPING * float(numpy.sqrt(STIFFNESS[j] * (ARMATURE[j] + INERTIA[j])))!r}"/>'
        for j in range(6))
    tendons, gaps = "", [j for j in range(6) if robot["gap_half"][j] > 0]
    for j in gaps:
        parts = ["motor", "gap"] + (["gear"] if robot["compliance"][j] > 0 else [])
        tendons += (f'<fixed frictionloss="{robot["gap_friction"][j]!r}" solreffriction="0.002 1" '
                    f'solimpfriction="0.9999 0.9999 0.001">'
                    + "".join(f'<joint joint="{part}{j}" coef="1"/>' for part in parts) + "</fixed>")
    compiled = mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler angle="radian" inertiafromgeom="false"/>'
        f'<option timestep="{robot["step_s"]!r}" integrator="implicit" gravity="0 0 -9.80665" tolerance="1e-12"/>'
        f"<worldbody>{text}</worldbody><tendon>{tendons}</tendon><actuator>{drives}</actuator></mujoco>")
    # How hard stops and friction hold goes by the inertia at joint angles 0, where the wrist lies on the axis of joint 4 and
    # has next to none. Say what they really hold.
    for tendon, j in enumerate(gaps):
        compiled.dof_invweight0[compiled.joint(f"gap{j}").dofadr[0]] = compiled.tendon_invweight0[tendon] = 1 / INERTIA[j]
    return compiled


def drive(robot, payload_kg, command):
    """Motor angles and tool point at each step of the command."""
    m = model(robot, payload_kg)
    d = mujoco.MjData(m)
    motors = [m.joint(f"motor{j}").qposadr[0] for j in range(6)]
    speed = numpy.gradient(command, robot["step_s"], axis=0)
    site = m.site("tool").id
    d.qpos[motors], d.qvel[[m.joint(f"motor{j}").dofadr[0] for j in range(6)]] = command[0], speed[0]
    out = numpy.empty((len(command), 9))
    for k in range(len(command)):
        d.ctrl[:6], d.ctrl[6:] = command[k], speed[k]
        mujoco.mj_forward(m, d) if k == 0 else mujoco.mj_step(m, d)
        # A step leaves the places of its begin; those of its end belong to the angles now in qpos.
        mujoco.mj_kinematics(m, d)
        out[k, :6], out[k, 6:] = d.qpos[motors], d.site_xpos[site]
    return out


def main():
    folder = sys.argv[1]
    with open(os.path.join(folder, "job.json")) as file:
        job = json.load(file)
    commands = numpy.fromfile(os.path.join(folder, "commands.bin")).reshape(-1, 6)
    begin = 0
    with open(os.path.join(folder, "results.bin"), "wb") as file:
        for way in job["ways"]:
            file.write(drive(job["robot"], way["payload_kg"], commands[begin : begin + way["count"]]).tobytes())
            begin += way["count"]
    return 0


if __name__ == "__main__":
    sys.exit(main())
