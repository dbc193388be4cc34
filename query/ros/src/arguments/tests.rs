use super::*;

fn read(line: &str) -> anyhow::Result<Arguments> {
    Arguments::read(line.split_whitespace().map(OsString::from))
}

fn error(line: &str) -> String {
    let error = read(line).unwrap_err();
    format!("{error:#}")
}

fn value(arguments: &Arguments, name: &str) -> String {
    let parameters = arguments.options.parameters();
    let (_, value) = parameters.into_iter().find(|(known, _)| *known == name).unwrap();
    format!("{value:?}")
}

#[test]
fn parameters_are_options_and_options_win() {
    let arguments =
        read("--ros-args -p hand:=left -p recall:=1 -p exact:=true -p thorough:=true -p index:='x.idx'")
            .unwrap();
    assert_eq!(value(&arguments, "hand"), r#"String("left")"#);
    assert_eq!(value(&arguments, "recall"), "Double(1.0)");
    assert_eq!(value(&arguments, "exact"), "Boolean(true)");
    assert!(arguments.options.recognition().thorough);
    assert_eq!(arguments.options.index(), Some("x.idx".into()));
    let arguments = read("--hand right --exact --ros-args -p hand:=left -- --recall 0.5").unwrap();
    assert_eq!(value(&arguments, "hand"), r#"String("right")"#);
    assert_eq!(value(&arguments, "exact"), "Boolean(true)");
    assert_eq!(value(&arguments, "recall"), "Double(0.5)");
}

#[test]
fn rectified_pictures_are_known_by_their_topic_or_by_a_parameter() {
    let is_rectified = |line: &str| {
        let Arguments { options, names, .. } = read(line).unwrap();
        options.is_rectified(&names.topic("image").unwrap())
    };
    for topic in ["/camera/image_rect", "/camera/image_rect_color", "image_rect_raw"] {
        assert!(is_rectified(&format!("--ros-args -r image:={topic}")), "{topic}");
    }
    for topic in ["/camera/image_raw", "/image_rect/image", "image"] {
        assert!(!is_rectified(&format!("--ros-args -r image:={topic}")), "{topic}");
        assert!(is_rectified(&format!("--ros-args -r image:={topic} -p rectified:=true")), "{topic}");
    }
    assert!(!is_rectified("--rectified false --ros-args -r image:=/camera/image_rect"));
    assert!(error("--rectified yes").contains("possible values: auto, true, false"));
}

#[test]
fn names_are_remapped() {
    let line =
        "--ros-args -r __ns:=/arm -r __node:=eye -r image:=/camera/image_raw --remap eye:camera_info:=info";
    let names = read(line).unwrap().names;
    assert_eq!(names.node_path(), "/arm/eye");
    assert_eq!(names.topic("image").unwrap(), "/camera/image_raw");
    assert_eq!(names.topic("camera_info").unwrap(), "/arm/info");
    assert_eq!(names.topic("~/pose").unwrap(), "/arm/eye/pose");
}

#[test]
fn the_nodes_own_names_may_be_given_for_it_and_more_than_once() {
    let names = |line: &str| read(&format!("--ros-args {line}")).unwrap().names;
    for (line, path) in [
        ("-r grasp:__ns:=/arm", "/arm/grasp"),
        ("-r grasp:__node:=eye -r eye:__ns:=/arm", "/arm/eye"),
        ("-r other:__node:=eye -r other:__ns:=/arm", "/grasp"),
        // As by rcl, the first that is for the node.
        ("-r other:__ns:=/a -r __ns:=/b -r __ns:=/c", "/b/grasp"),
        ("-r __node:=one -r __node:=two", "/one"),
    ] {
        let names = names(line);
        assert_eq!(names.node_path(), path, "{line}");
        assert_eq!(names.topic("/image").unwrap(), "/image", "{line}");
    }
}

#[test]
fn what_is_said_for_another_node_is_not_ours() {
    let arguments = read("--ros-args -p other:hand:=both -p grasp:hand:=left -p use_sim_time:=true").unwrap();
    assert_eq!(value(&arguments, "hand"), r#"String("left")"#);
}

#[test]
fn mistakes_say_what_would_be_right() {
    assert!(
        error("--ros-args -p hnad:=left").contains("there is no parameter hnad: there are index, no_mmap")
    );
    assert!(error("--ros-args -p hand:=both").contains("possible values: auto, left, right"));
    assert!(error("--ros-args -p hand").contains("LEFT:=RIGHT"));
    assert!(error("--ros-args -p").contains("-p needs a value"));
    assert!(error("--ros-args --fast").contains("--fast behind --ros-args is not known"));
    assert!(error("--ros-args --log-level loud").contains("debug, info, warn"));
    assert!(error("--robot barrett").contains("--object and --camera"));
    assert!(error("--ros-args -p arm:=kuka-kr6-r700").contains("--robot"));
    assert!(error("--ros-args -r __ns:=/a//b").contains("no name"));
    assert!(
        error("--ros-args --params-file missing.yaml").contains("cannot read the parameters of missing.yaml")
    );
}

#[test]
fn what_launch_files_add_is_accepted() {
    let line = "--ros-args --log-level grasp:=debug --disable-stdout-logs -e / -p robot:= __node:=eye";
    let arguments = read(line).unwrap();
    assert_eq!((arguments.level, arguments.names.node()), (Level::Debug, "eye"));
    assert!(arguments.options.robot().is_none());
}

/// What a file has for the node /arm/eye.
fn of_file(text: &str) -> anyhow::Result<Vec<(String, String)>> {
    let names = Names::new("/arm", "eye", Vec::new()).unwrap();
    parameter_file::of_text(text, &names)
}

#[test]
fn a_file_of_parameters_is_for_the_nodes_that_it_names() {
    let text = "\
/**:
  ros__parameters:
    hand: left
    recall: 0.9
/arm/eye:
  ros__parameters:
    hand: right
    exact: true
    nested: {k: 3}
    index: \"2026\"
/arm/other:
  ros__parameters: {hand: auto}
/*/eye:
  ros__parameters: {rolls: 8}
";
    let found = of_file(text).unwrap();
    let expected = [
        ("exact", "true"),
        ("hand", "right"),
        ("index", "2026"),
        ("nested.k", "3"),
        ("recall", "0.9"),
        ("rolls", "8"),
    ];
    assert_eq!(found, expected.map(|(name, value)| (name.to_owned(), value.to_owned())));
    let nested = of_file("arm:\n  eye:\n    ros__parameters:\n      hand: left\n").unwrap();
    assert_eq!(nested, [("hand".to_owned(), "left".to_owned())]);
}

#[test]
fn a_file_that_is_none_is_an_error() {
    for text in ["[1, 2]", "a: 1", "a: {b: 1}", ": [", "- a"] {
        assert!(of_file(text).is_err(), "{text:?}");
    }
    let deep = (0..100).map(|depth| format!("{}a:\n", " ".repeat(depth))).collect::<String>() + "\n";
    assert!(of_file(&(deep + &" ".repeat(100) + "ros__parameters: {hand: left}\n")).is_err());
}

#[test]
fn a_files_unknown_parameters_are_ignored_with_a_word() {
    let folder = std::env::temp_dir().join(format!("grasp-ros-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("parameters.yaml");
    std::fs::write(&file, "/**:\n  ros__parameters: {hand: left, frame_rate: 30, use_sim_time: true}\n")
        .unwrap();
    let arguments = read(&format!("--ros-args --params-file {}", file.display())).unwrap();
    assert_eq!(value(&arguments, "hand"), r#"String("left")"#);
    assert_eq!(arguments.ignored.len(), 1);
    assert!(arguments.ignored[0].contains("frame_rate"), "{:?}", arguments.ignored);
    std::fs::remove_dir_all(&folder).unwrap();
}
