//! The layout of a recording in the viewer.
//!
//! The SDK's builders give every part a random name, and cannot set ranges, legends and bounds.

pub(crate) mod run;

use crate::ViewerError;
use crate::writer::{TIMELINE, Writer};
use rerun::components::Range1D;
use rerun::datatypes::{
    Bool, Range1D as Range, Range2D, TimeRange, TimeRangeBoundary, VisibleTimeRange,
};
use rerun::external::re_sdk_types::blueprint::archetypes::{
    ContainerBlueprint, PanelBlueprint, PlotLegend, ScalarAxis, TextLogColumns, TimeAxis,
    TimePanelBlueprint, ViewBlueprint, ViewContents, ViewportBlueprint, VisibleTimeRanges,
    VisualBounds2D,
};
pub(crate) use rerun::external::re_sdk_types::blueprint::components::ContainerKind;
use rerun::external::re_sdk_types::blueprint::components::{
    LinkAxis, LoopMode, PanelState, PlayState,
};
use rerun::external::re_sdk_types::blueprint::datatypes::{TextLogColumn, TextLogColumnKind};
use rerun::external::uuid::Uuid;
use rerun::{AsComponents, EntityPath};

/// A view, or a container of parts with their shares of its width or height.
pub(crate) enum Part {
    View(View),
    Container(ContainerKind, String, Vec<(Part, f32)>),
}

/// A view of a class of the viewer.
pub(crate) struct View {
    class: &'static str,
    name: String,
    origin: String,
    contents: Vec<String>,
    /// Names in the layout's store, and values.
    properties: Vec<(&'static str, Box<dyn AsComponents>)>,
    /// Entities of which it shows all rows up to the cursor, instead of the newest row alone.
    past: Vec<String>,
}

/// Logs a layout and makes it the active one. The cursor of a live run stays at the newest record;
/// that of a finished run plays from the start, repeatedly.
pub(crate) fn log(out: &mut Writer, root: &Part, is_live: bool) -> Result<(), ViewerError> {
    let root = root.log(out, &mut 0)?;
    let viewport = ViewportBlueprint::new()
        .with_root_container(root.id)
        .with_auto_layout(false)
        .with_auto_views(false);
    out.layout("viewport", &viewport)?;
    panels(out, is_live)?;
    out.activate_layout();
    Ok(())
}

/// A part that has been logged.
struct Logged {
    id: Uuid,
    /// Its entity in the layout's store.
    path: String,
}

impl Logged {
    /// The next of `parts`. Its name follows from its number.
    fn next(kind: &str, parts: &mut u128) -> Self {
        *parts += 1;
        let id = Uuid::from_u128(*parts);
        let path = format!("{kind}/{id}");
        Self { id, path }
    }
}

impl Part {
    fn log(&self, out: &mut Writer, parts: &mut u128) -> Result<Logged, ViewerError> {
        match self {
            Self::View(view) => view.log(out, parts),
            Self::Container(kind, name, children) => {
                let mut inner = Vec::new();
                for (part, _) in children {
                    inner.push(part.log(out, parts)?.path);
                }
                let container = Logged::next("container", parts);
                let shares = children.iter().map(|(_, share)| *share);
                let mut blueprint = ContainerBlueprint::new(*kind)
                    .with_display_name(name.as_str())
                    .with_contents(inner.iter().map(String::as_str));
                blueprint = match (kind, inner.first()) {
                    (ContainerKind::Horizontal, _) => blueprint.with_col_shares(shares),
                    (ContainerKind::Vertical, _) => blueprint.with_row_shares(shares),
                    // The first tab is visible when the recording opens.
                    (_, Some(first)) => blueprint.with_active_tab(first.as_str()),
                    (_, None) => blueprint,
                };
                out.layout(container.path.as_str(), &blueprint)?;
                Ok(container)
            }
        }
    }

    /// A view of a class of the viewer, of the entities `contents`.
    pub(crate) fn of_class(class: &'static str, name: &str, origin: &str, contents: &str) -> Self {
        Self::View(View::new(class, name, origin, &[contents]))
    }

    /// A 2-D view. `bounds` are the visible ranges in the frame of `origin`: left to right and top
    /// to bottom (y down). Of the entities `past` all rows up to the cursor are shown.
    pub(crate) fn spatial(
        name: &str,
        origin: &str,
        contents: &[&str],
        bounds: [[f64; 2]; 2],
        past: Vec<String>,
    ) -> Self {
        let bounds = VisualBounds2D::new(Range2D {
            x_range: Range(bounds[0]),
            y_range: Range(bounds[1]),
        });
        Self::View(View {
            properties: vec![("VisualBounds2D", Box::new(bounds))],
            past,
            ..View::new("2D", name, origin, contents)
        })
    }

    /// A plot over time of the entities below `entity`. `range` is that of the vertical axis;
    /// `None` means the range of the data.
    pub(crate) fn plot(name: &str, entity: &str, range: Option<Range1D>) -> Self {
        let axis = range.map_or(ScalarAxis::new(), |range| {
            ScalarAxis::new().with_range(range)
        });
        Self::View(View {
            // All plots show the same range of time. The key is a view of its own, so that it does
            // not cover lines.
            properties: vec![
                (
                    "TimeAxis",
                    Box::new(TimeAxis::new().with_link(LinkAxis::LinkToGlobal)),
                ),
                (
                    "PlotLegend",
                    Box::new(PlotLegend::new().with_visible(false)),
                ),
                ("ScalarAxis", Box::new(axis)),
            ],
            ..View::new("TimeSeries", name, "/", &[&format!("+ {entity}/**")])
        })
    }

    /// A list of text messages with their times.
    pub(crate) fn text_log(name: &str, entity: &str) -> Self {
        let columns = [TextLogColumnKind::LogLevel, TextLogColumnKind::Body];
        let columns = columns.map(|kind| TextLogColumn {
            visible: Bool(true),
            kind,
        });
        let columns = TextLogColumns::new().with_text_log_columns(columns);
        Self::View(View {
            properties: vec![("TextLogColumns", Box::new(columns))],
            ..View::new("TextLog", name, entity, &[&format!("+ {entity}")])
        })
    }

    /// Tabs, of which one is visible at a time.
    pub(crate) fn tabs(name: &str, parts: Vec<Self>) -> Self {
        Self::equal(ContainerKind::Tabs, name, parts)
    }

    /// Parts with equal shares.
    pub(crate) fn equal(
        kind: ContainerKind,
        name: &str,
        parts: impl IntoIterator<Item = Self>,
    ) -> Self {
        let parts = parts.into_iter().map(|part| (part, 1.0)).collect();
        Self::Container(kind, name.to_owned(), parts)
    }

    /// Parts one below the other, with their shares of the height.
    pub(crate) fn column(name: &str, parts: Vec<(Self, f32)>) -> Self {
        Self::Container(ContainerKind::Vertical, name.to_owned(), parts)
    }
}

impl View {
    fn new(class: &'static str, name: &str, origin: &str, contents: &[&str]) -> Self {
        Self {
            class,
            name: name.to_owned(),
            origin: origin.to_owned(),
            contents: contents.iter().map(|c| (*c).to_owned()).collect(),
            properties: Vec::new(),
            past: Vec::new(),
        }
    }

    fn log(&self, out: &mut Writer, parts: &mut u128) -> Result<Logged, ViewerError> {
        let view = Logged::next("view", parts);
        let blueprint = ViewBlueprint::new(self.class)
            .with_display_name(self.name.as_str())
            .with_space_origin(self.origin.as_str());
        let path = &view.path;
        out.layout(path.as_str(), &blueprint)?;
        let contents = ViewContents::new(self.contents.iter().map(String::as_str));
        out.layout(format!("{path}/ViewContents"), &contents)?;
        for (name, property) in &self.properties {
            out.layout(format!("{path}/{name}"), property.as_ref())?;
        }
        for entity in &self.past {
            let entity = EntityPath::from(entity.as_str());
            let entity = ViewContents::blueprint_base_visualizer_path_for_entity(view.id, &entity);
            let until_now = VisibleTimeRange {
                timeline: TIMELINE.into(),
                range: TimeRange {
                    start: TimeRangeBoundary::Infinite,
                    end: TimeRangeBoundary::CursorRelative(0.into()),
                },
            };
            out.layout(entity, &VisibleTimeRanges::new([until_now]))?;
        }
        Ok(view)
    }
}

/// Collapses the panels around the views, and sets the movement of the cursor.
fn panels(out: &mut Writer, is_live: bool) -> Result<(), ViewerError> {
    for panel in ["blueprint_panel", "selection_panel"] {
        let collapsed = PanelBlueprint::new().with_state(PanelState::Collapsed);
        out.layout(panel, &collapsed)?;
    }
    // The collapsed panel still has the cursor and the buttons.
    let (play, repeat) = match is_live {
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
