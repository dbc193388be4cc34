"""A small message of each type, with a value of its own in every field.

`message(kinds, name)` builds it of any classes that are named and shaped as ROS's are: those of
`messages`, and those of `rclpy`'s packages.
"""

NUMBERS = [0.5 * number for number in range(1, 37)]


def header(kinds):
    return kinds.Header(stamp=kinds.Time(sec=7, nanosec=80), frame_id="cam")


def pose(kinds):
    return kinds.Pose(
        position=kinds.Point(x=1.0, y=2.0, z=3.0),
        orientation=kinds.Quaternion(x=0.5, y=-0.5, z=0.5, w=-0.5),
    )


def image(kinds):
    return kinds.Image(
        header=header(kinds),
        height=1,
        width=2,
        encoding="rgb8",
        is_bigendian=1,
        step=7,
        data=bytes([1, 2, 3, 4, 5, 6, 7]),
    )


def compressed_image(kinds):
    return kinds.CompressedImage(header=header(kinds), format="jpeg", data=bytes([255, 216, 255]))


def camera_info(kinds):
    return kinds.CameraInfo(
        header=header(kinds),
        height=480,
        width=640,
        distortion_model="plumb_bob",
        d=NUMBERS[:5],
        k=NUMBERS[:9],
        r=NUMBERS[1:10],
        p=NUMBERS[2:14],
        binning_x=1,
        binning_y=2,
        roi=kinds.RegionOfInterest(x_offset=3, y_offset=4, height=5, width=6, do_rectify=True),
    )


def pose_stamped(kinds):
    return kinds.PoseStamped(header=header(kinds), pose=pose(kinds))


def marker_array(kinds):
    marker = kinds.Marker(
        header=header(kinds),
        ns="hand",
        id=1,
        type=5,
        action=3,
        pose=pose(kinds),
        scale=kinds.Vector3(x=0.25, y=0.5, z=0.75),
        color=kinds.ColorRGBA(r=0.25, g=0.5, b=0.75, a=1.0),
        lifetime=kinds.Duration(sec=1, nanosec=2),
        frame_locked=True,
        points=[kinds.Point(x=4.0, y=5.0, z=6.0)],
        colors=[kinds.ColorRGBA(r=1.0, g=0.75, b=0.5, a=0.25)],
        texture_resource="t",
        texture=compressed_image(kinds),
        uv_coordinates=[kinds.UVCoordinate(u=0.25, v=0.75)],
        text="pinch",
        mesh_resource="m",
        mesh_file=kinds.MeshFile(filename="f", data=bytes([9])),
        mesh_use_embedded_materials=True,
    )
    return kinds.MarkerArray(markers=[marker])


def detection_2d_array(kinds):
    result = kinds.ObjectHypothesisWithPose(
        hypothesis=kinds.ObjectHypothesis(class_id="pinch", score=0.75),
        pose=kinds.PoseWithCovariance(pose=pose(kinds), covariance=NUMBERS),
    )
    centre = kinds.Pose2D(position=kinds.Point2D(x=10.0, y=20.0), theta=0.25)
    detection = kinds.Detection2D(
        header=header(kinds),
        results=[result],
        bbox=kinds.BoundingBox2D(center=centre, size_x=30.0, size_y=40.0),
        id="a",
    )
    return kinds.Detection2DArray(header=header(kinds), detections=[detection])


def grasp(kinds):
    def posture(first):
        point = kinds.JointTrajectoryPoint(
            positions=[first, 0.5],
            velocities=[1.5],
            accelerations=[2.5],
            effort=[3.5],
            time_from_start=kinds.Duration(sec=1, nanosec=5),
        )
        names = ["one", "three"]
        return kinds.JointTrajectory(header=header(kinds), joint_names=names, points=[point])

    def translation(least):
        vector = kinds.Vector3(x=0.0, y=0.5, z=1.0)
        return kinds.GripperTranslation(
            direction=kinds.Vector3Stamped(header=header(kinds), vector=vector),
            desired_distance=0.5,
            min_distance=least,
        )

    return kinds.Grasp(
        id="wrap",
        pre_grasp_posture=posture(0.25),
        grasp_posture=posture(0.75),
        grasp_pose=pose_stamped(kinds),
        grasp_quality=0.875,
        pre_grasp_approach=translation(0.125),
        post_grasp_retreat=translation(0.25),
        post_place_retreat=translation(0.375),
        max_contact_force=15.0,
        allowed_touch_objects=["cup"],
    )


BUILDERS = {
    "sensor_msgs/Image": image,
    "sensor_msgs/CompressedImage": compressed_image,
    "sensor_msgs/CameraInfo": camera_info,
    "geometry_msgs/PoseStamped": pose_stamped,
    "vision_msgs/Detection2DArray": detection_2d_array,
    "visualization_msgs/MarkerArray": marker_array,
    "moveit_msgs/Grasp": grasp,
}


def message(kinds, name):
    """The sample of a type, `package/Name`, of the classes that `kinds` has."""
    return BUILDERS[name](kinds)
