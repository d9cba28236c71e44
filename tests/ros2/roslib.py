"""A client of rosbridge by roslibpy. Usage: roslib.py PORT; it prints what it saw as JSON."""

import json
import sys
import time

import roslibpy


def main(port):
    ros = roslibpy.Ros(host="127.0.0.1", port=int(port))
    ros.run(timeout=20)
    odom, end = [], time.time() + 20
    while "/R1/robot_description" not in ros.get_topics():
        assert time.time() < end, "the robot does not come"
    topics = {topic: ros.get_topic_type(topic) for topic in ros.get_topics()}
    roslibpy.Topic(ros, "/R1/odom", "nav_msgs/Odometry").subscribe(odom.append)
    command = roslibpy.Topic(ros, "/R1/cmd_vel", "geometry_msgs/Twist")
    speed, end = 0.0, time.time() + 60
    while abs(speed - 0.5) >= 0.01:
        assert time.time() < end, speed
        command.publish(roslibpy.Message({"linear": {"x": 0.5}}))
        time.sleep(0.1)
        speed = odom[-1]["twist"]["twist"]["linear"]["x"] if odom else 0.0
    paused = roslibpy.Service(ros, "/usarsim/pause", "std_srvs/Trigger").call(roslibpy.ServiceRequest())
    print(json.dumps({"topics": topics, "services": ros.get_services(), "speed": speed, "paused": dict(paused)}))
    ros.terminate()


if __name__ == "__main__":
    main(sys.argv[1])
