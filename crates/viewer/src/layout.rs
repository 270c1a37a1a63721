//! The layout of a recording in the viewer: animation, events and flags on the left, time series on
//! the right.
//!
//! The SDK's builders give every part a random name, and cannot set ranges, legends and bounds.

use crate::ViewerError;
use crate::draw::narrow;
use crate::estimated_terrain::{LEFT, bounds_of};
use crate::explain::{KEY_HEIGHT, key_width};
use crate::ground::{Ground, ROOM};
use crate::scene_view::FOLLOWED;
use crate::series::WHEEL_NAMES;
use crate::writer::{TIMELINE, Writer};
use re_log_types::EntityPath;
use re_sdk_types::AsComponents;
use re_sdk_types::blueprint::archetypes::{
    ContainerBlueprint, EyeControls3D, LineGrid3D, PanelBlueprint, PlotLegend, ScalarAxis,
    TextLogColumns, TimeAxis, TimePanelBlueprint, ViewBlueprint, ViewContents, ViewportBlueprint,
    VisibleTimeRanges, VisualBounds2D,
};
use re_sdk_types::blueprint::components::{
    ContainerKind, LinkAxis, LoopMode, PanelState, PlayState,
};
use re_sdk_types::blueprint::datatypes::{TextLogColumn, TextLogColumnKind};
use re_sdk_types::components::Range1D;
use re_sdk_types::datatypes::{
    Bool, Range1D as Range, Range2D, TimeRange, TimeRangeBoundary, VisibleTimeRange,
};
use robhaz_model::WholeRover;
use robhaz_run::{EstimatorDescription, RunDescription};
use robhaz_scene::Scene;
use uuid::Uuid;

/// A view, or a container of parts with their shares of its width or height.
enum Part {
    View(View),
    Container(ContainerKind, String, Vec<(Part, f32)>),
}

/// Name in the layout's store, and value.
type Property = (&'static str, Box<dyn AsComponents>);

fn property(name: &'static str, value: impl AsComponents + 'static) -> Property {
    (name, Box::new(value))
}

/// A view of a class of the viewer.
struct View {
    class: &'static str,
    name: String,
    origin: String,
    contents: Vec<String>,
    properties: Vec<Property>,
    /// Entities of which it shows all rows up to the cursor, instead of the newest row alone.
    past: Vec<String>,
}

/// Logs the layout of a run and makes it the active one. The cursor of a live run stays at the
/// newest record; that of a finished run plays from the start, repeatedly.
pub(crate) fn log(out: &mut Writer, run: &RunDescription) -> Result<(), ViewerError> {
    let root = Part::equal(ContainerKind::Horizontal, "robhaz", [left(run), right(run)]);
    log_root(out, &root)
}

/// Logs the layout of a rover with both sides: the drive in 3-D at the left, plots at the right.
pub(crate) fn log_whole(out: &mut Writer, rover: &WholeRover) -> Result<(), ViewerError> {
    // Seen from the right, from behind and above, whatever the size of the rover.
    let axles = &rover.side.geometry.axles;
    let size = axles[0].x - axles[2].x;
    let eye = EyeControls3D::new()
        .with_position([-1.15, -1.35, 1.2].map(|share| narrow(share * size)))
        .with_look_target([0.0, 0.0, narrow(-0.15 * size)])
        .with_eye_up([0.0, 0.0, 1.0]);
    // The viewer's grid would move with the rover.
    let grid = LineGrid3D::new().with_visible(false);
    let eye = vec![property("EyeControls3D", eye), property("LineGrid3D", grid)];
    let drive = View::new(
        "3D",
        "The drive [m]: N and T at the contacts",
        "/world/follow",
        &["+ /world/**"],
        eye,
    );
    let drive = View {
        past: vec!["/world/tracks".to_owned()],
        ..drive
    };
    let about = Part::of_class("TextDocument", "About", "/about", "+ /about");
    let left = vec![(Part::View(drive), 4.0), (about, 1.0)];
    let left = Part::Container(ContainerKind::Vertical, "Scene".to_owned(), left);
    let load = rover.mean_wheel_load();
    let normal = Some(Range1D::new(-0.1 * load, 3.0 * load));
    let traction = Some(Range1D::new(-2.0 * load, 2.0 * load));
    let plot = |(title, entity, range): (&str, &str, Option<Range1D>)| {
        Part::plot(title, &format!("/series/{entity}"), range)
    };
    let rows = [
        vec![
            ("N, left wheels [N]", "normal_force/left", normal),
            ("N, right wheels [N]", "normal_force/right", normal),
        ],
        vec![
            ("T, left wheels [N]", "traction/left", traction),
            ("T, right wheels [N]", "traction/right", traction),
        ],
        vec![
            ("Attitude [deg]", "attitude", None),
            ("Tip margin [-]", "tip_margin", Some(Range1D::new(0.0, 1.2))),
            ("Axial share [-]", "axial_share", None),
        ],
    ];
    let rows = rows.map(|row| {
        Part::equal(
            ContainerKind::Horizontal,
            "Plots",
            row.into_iter().map(plot),
        )
    });
    let right = Part::equal(ContainerKind::Vertical, "Time series", rows);
    let root = Part::equal(ContainerKind::Horizontal, "robhaz", [left, right]);
    log_root(out, &root)
}

/// Logs the layout of a root container, and makes it the active one.
fn log_root(out: &mut Writer, root: &Part) -> Result<(), ViewerError> {
    let (root, _) = root.log(out, &mut 0)?;
    let viewport = ViewportBlueprint::new()
        .with_root_container(root)
        .with_auto_layout(false)
        .with_auto_views(false);
    out.layout("viewport", &viewport)?;
    panels(out)?;
    out.activate_layout()
}

/// Number of the next of `parts`, from which its name follows, and its entity in the layout's
/// store.
fn next(kind: &str, parts: &mut u128) -> (Uuid, String) {
    *parts += 1;
    let id = Uuid::from_u128(*parts);
    (id, format!("{kind}/{id}"))
}

impl Part {
    fn log(&self, out: &mut Writer, parts: &mut u128) -> Result<(Uuid, String), ViewerError> {
        let (kind, name, children) = match self {
            Self::View(view) => return view.log(out, parts),
            Self::Container(kind, name, children) => (kind, name, children),
        };
        let mut inner = Vec::new();
        for (part, _) in children {
            inner.push(part.log(out, parts)?.1);
        }
        let (id, path) = next("container", parts);
        let shares = children.iter().map(|(_, share)| *share);
        let blueprint = ContainerBlueprint::new(*kind)
            .with_display_name(name.as_str())
            .with_contents(inner.iter().map(String::as_str));
        let blueprint = match (kind, inner.first()) {
            (ContainerKind::Horizontal, _) => blueprint.with_col_shares(shares),
            (ContainerKind::Vertical, _) => blueprint.with_row_shares(shares),
            // The first tab is visible when the recording opens.
            (_, Some(first)) => blueprint.with_active_tab(first.as_str()),
            (_, None) => blueprint,
        };
        out.layout(path.as_str(), &blueprint)?;
        Ok((id, path))
    }

    /// A view of a class of the viewer, of the entities `contents`.
    fn of_class(class: &'static str, name: &str, origin: &str, contents: &str) -> Self {
        Self::View(View::new(class, name, origin, &[contents], Vec::new()))
    }

    /// A 2-D view. `bounds` are the visible ranges in the frame of `origin`: left to right and top
    /// to bottom (y down). Of the entities `past` all rows up to the cursor are shown.
    fn spatial(
        name: &str,
        origin: &str,
        contents: &[&str],
        [x, y]: [[f64; 2]; 2],
        past: Vec<String>,
    ) -> Self {
        let bounds = VisualBounds2D::new(Range2D {
            x_range: Range(x),
            y_range: Range(y),
        });
        let properties = vec![property("VisualBounds2D", bounds)];
        let view = View::new("2D", name, origin, contents, properties);
        Self::View(View { past, ..view })
    }

    /// A plot over time of the entities below `entity`. `range` is that of the vertical axis;
    /// `None` means the range of the data.
    fn plot(name: &str, entity: &str, range: Option<Range1D>) -> Self {
        let axis = ScalarAxis::new();
        let axis = range.map_or(axis.clone(), |range| axis.with_range(range));
        // All plots show the same range of time. The key is a view of its own, so that it does not
        // cover lines.
        let properties = vec![
            property(
                "TimeAxis",
                TimeAxis::new().with_link(LinkAxis::LinkToGlobal),
            ),
            property("PlotLegend", PlotLegend::new().with_visible(false)),
            property("ScalarAxis", axis),
        ];
        let contents = format!("+ {entity}/**");
        Self::View(View::new("TimeSeries", name, "/", &[&contents], properties))
    }

    /// A list of text messages with their times.
    fn text_log(name: &str, entity: &str) -> Self {
        let columns = [TextLogColumnKind::LogLevel, TextLogColumnKind::Body];
        let columns = columns.map(|kind| TextLogColumn {
            visible: Bool(true),
            kind,
        });
        let columns = TextLogColumns::new().with_text_log_columns(columns);
        let properties = vec![property("TextLogColumns", columns)];
        let contents = format!("+ {entity}");
        Self::View(View::new("TextLog", name, entity, &[&contents], properties))
    }

    /// Parts with equal shares.
    fn equal(kind: ContainerKind, name: &str, parts: impl IntoIterator<Item = Self>) -> Self {
        let parts = parts.into_iter().map(|part| (part, 1.0)).collect();
        Self::Container(kind, name.to_owned(), parts)
    }
}

impl View {
    fn new(
        class: &'static str,
        name: &str,
        origin: &str,
        contents: &[&str],
        properties: Vec<Property>,
    ) -> Self {
        Self {
            class,
            name: name.to_owned(),
            origin: origin.to_owned(),
            contents: contents.iter().map(|c| (*c).to_owned()).collect(),
            properties,
            past: Vec::new(),
        }
    }

    fn log(&self, out: &mut Writer, parts: &mut u128) -> Result<(Uuid, String), ViewerError> {
        let (id, path) = next("view", parts);
        let blueprint = ViewBlueprint::new(self.class)
            .with_display_name(self.name.as_str())
            .with_space_origin(self.origin.as_str());
        out.layout(path.as_str(), &blueprint)?;
        let contents = ViewContents::new(self.contents.iter().map(String::as_str));
        out.layout(format!("{path}/ViewContents"), &contents)?;
        for (name, property) in &self.properties {
            out.layout(format!("{path}/{name}"), property.as_ref())?;
        }
        for entity in &self.past {
            let entity = EntityPath::from(entity.as_str());
            let entity = ViewContents::blueprint_base_visualizer_path_for_entity(id, &entity);
            let until_now = VisibleTimeRange {
                timeline: TIMELINE.into(),
                range: TimeRange {
                    start: TimeRangeBoundary::Infinite,
                    end: TimeRangeBoundary::CursorRelative(0.into()),
                },
            };
            out.layout(entity, &VisibleTimeRanges::new([until_now]))?;
        }
        Ok((id, path))
    }
}

/// Collapses the panels around the views, and sets the movement of the cursor.
fn panels(out: &mut Writer) -> Result<(), ViewerError> {
    for panel in ["blueprint_panel", "selection_panel"] {
        let collapsed = PanelBlueprint::new().with_state(PanelState::Collapsed);
        out.layout(panel, &collapsed)?;
    }
    // The collapsed panel still has the cursor and the buttons.
    let (play, repeat) = match out.is_live() {
        false => (PlayState::Playing, LoopMode::All),
        true => (PlayState::Following, LoopMode::Off),
    };
    let time = TimePanelBlueprint::new()
        .with_state(PanelState::Collapsed)
        .with_timeline(TIMELINE)
        .with_play_state(play)
        .with_loop_mode(repeat);
    out.layout("time_panel", &time)
}

fn left(run: &RunDescription) -> Part {
    let mut rows = Vec::new();
    if let Some(world) = &run.world {
        rows.push((overview(&Ground::new(run, world)), 1.0));
        rows.push((following(), 2.5));
    }
    let lanes =
        |name, entity| Part::of_class("StateTimeline", name, entity, &format!("+ {entity}/**"));
    let mut tabs = vec![Part::text_log("Events", "/events")];
    let states = |e: &EstimatorDescription| e.settings.states_covariance();
    if run.world.is_some() || run.estimators.iter().any(states) {
        tabs.push(lanes("Wheels", "/wheels"));
    }
    let about = Part::of_class("TextDocument", "About", "/about", "+ /about");
    tabs.push(about);
    let tabs = Part::equal(ContainerKind::Tabs, "Events, wheels, about", tabs);
    let trust = lanes("Flags of the estimators", "/trust");
    let below = vec![(tabs, 1.4), (trust, 1.0)];
    let below = Part::Container(ContainerKind::Horizontal, "What happens".to_owned(), below);
    rows.push((below, 1.0));
    Part::Container(ContainerKind::Vertical, "Scene".to_owned(), rows)
}

/// The whole ground of a simulation, with the robot and the paths of its pins.
fn overview(ground: &Ground) -> Part {
    let [from, to, low, high] = ground.box_of();
    let contents = [
        "+ /world/**",
        "- /world/follow/**",
        // The robot is too small here for labels, end stops and a second set of arrows.
        "- /world/robot/pins",
        "- /world/robot/link2/stops",
        "- /world/forces/estimated/**",
    ];
    // The view has y down. The robot is above the ground; the arrows of N and the axis are below
    // it.
    let bounds = [[from, to], [-(high + 0.45), ROOM - low]];
    Part::spatial("Whole run [m]", "/", &contents, bounds, paths())
}

/// The robot in a view that moves with its body.
fn following() -> Part {
    let [half_width, above, below] = FOLLOWED;
    // The axis of the whole ground is left out.
    let contents = ["+ /world/**", "- /world/scale/**"];
    let name = "Along with the body [m]: N and T at the contacts";
    let bounds = [[-half_width, half_width], [-above, below]];
    Part::spatial(name, "/world/follow", &contents, bounds, paths())
}

/// The paths of the pins and the ground that was found, shown up to the cursor.
fn paths() -> Vec<String> {
    let entities = ["world/trails".to_owned(), LEFT.to_owned(), bounds_of(LEFT)];
    entities.map(|entity| format!("/{entity}")).into()
}

fn right(run: &RunDescription) -> Part {
    let bounds = [[0.0, key_width(run)], [0.0, KEY_HEIGHT]];
    let key = Part::spatial("Lines", "/key", &["+ /key/**"], bounds, Vec::new());
    let rows = vec![(key, 0.4), (forces(run), 3.2), (others(run), 1.1)];
    Part::Container(ContainerKind::Vertical, "Time series".to_owned(), rows)
}

/// N, its error and T of each wheel.
fn forces(run: &RunDescription) -> Part {
    let per_wheel = |title: &str, quantity: &str, range| {
        let plots = WHEEL_NAMES.iter().enumerate().map(|(i, wheel)| {
            let title = format!("{title}, {wheel} wheel [N]");
            Part::plot(&title, &format!("/series/{quantity}/wheel{}", i + 1), range)
        });
        Part::equal(ContainerKind::Vertical, title, plots)
    };
    let range = range_of_loads(run, -0.5, 3.0).unwrap_or_else(|| {
        let load = run.robot.robot.mean_wheel_load();
        Range1D::new(-0.1 * load, 3.0 * load)
    });
    let mut tabs = vec![per_wheel("Normal force N", "normal_force", Some(range))];
    if run.has_truth {
        let range = range_of_loads(run, -1.0, 1.0);
        tabs.push(per_wheel("Error of N", "error_of_normal_force", range));
    }
    let range = range_of_loads(run, -2.0, 2.0);
    tabs.push(per_wheel("Traction T", "traction", range));
    Part::equal(ContainerKind::Tabs, "Forces", tabs)
}

/// The range of an axis on ground with corners, from two multiples of the mean static wheel load,
/// N. Peaks at corners are shorter than a millisecond and would compress all other values. `None`
/// on other ground: the range of the data.
fn range_of_loads(run: &RunDescription, from: f64, to: f64) -> Option<Range1D> {
    let load = run.robot.robot.mean_wheel_load();
    let ground = run.world.as_ref()?.terrain.build(&run.robot.robot);
    (ground.has_corners()).then(|| Range1D::new(from * load, to * load))
}

/// What follows from the forces, and residuals.
fn others(run: &RunDescription) -> Part {
    let most = run.world.as_ref().map(|w| 1.25 * largest_friction(w));
    let mut tabs = Vec::new();
    let mut plot = |title: &str, quantity: &str, range: Option<Range1D>| {
        tabs.push(Part::plot(title, &format!("/series/{quantity}"), range));
    };
    if run.has_truth {
        let range = range_of_loads(run, 0.0, 1.0);
        let title = "Error of N, RMS of the wheels [N]";
        plot(title, "error_of_normal_force/rms", range);
    }
    plot("Contact angle [deg]", "contact_angle", None);
    let needed = most.map(|most| Range1D::new(-most, most));
    plot("Needed friction T/N [-]", "friction", needed);
    if let Some(most) = most {
        let left_over = Range1D::new(-0.25 * most, most);
        plot("Slip margin [-]", "slip_margin", Some(left_over));
    }
    if run.takes_commands() {
        plot("Commanded torque [N m]", "commanded_torque", None);
    }
    plot("Residual [N]", "residual/force", None);
    plot("Residual [N m]", "residual/moment", None);
    plot("Parity [N]", "parity", None);
    Part::equal(ContainerKind::Tabs, "Derived", tabs)
}

/// The largest static coefficient of the ground, -.
fn largest_friction(world: &Scene) -> f64 {
    let stretches = world.terrain.stretches.iter().map(|s| s.mu_s);
    stretches.fold(world.friction.mu_s, f64::max)
}
