//! The layout of a recording in the viewer.
//!
//! It is written part by part. The SDK's builders give every part a random name, and cannot set ranges, legends and
//! bounds.

pub(crate) mod comparison;
pub(crate) mod parts;
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

/// Movement of the time cursor when the viewer opens a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Playing {
    /// The cursor plays from the start, repeatedly: for a finished run.
    FromStart,
    /// The cursor stays at the newest record: for a live run.
    AtTheEnd,
}

/// A view or container that has been logged.
#[derive(Clone, Copy)]
pub(crate) struct Part {
    kind: &'static str,
    id: Uuid,
}

impl Part {
    /// Its entity in the layout's store.
    fn path(self) -> String {
        format!("{}/{}", self.kind, self.id)
    }
}

/// A property of a view: its name in the layout's store, and its value.
type Property<'a> = (&'static str, &'a dyn AsComponents);

/// Writes a layout part by part.
pub(crate) struct Layout<'a> {
    out: &'a mut Writer,
    /// Number of parts so far.
    parts: u128,
}

impl<'a> Layout<'a> {
    /// An empty layout.
    pub(crate) fn new(out: &'a mut Writer) -> Self {
        Self { out, parts: 0 }
    }

    /// Makes a part the root of the layout, and the layout the active one.
    pub(crate) fn finish(mut self, root: Part, playing: Playing) -> Result<(), ViewerError> {
        let viewport = ViewportBlueprint::new()
            .with_root_container(root.id)
            .with_auto_layout(false)
            .with_auto_views(false);
        self.out.layout("viewport", &viewport)?;
        self.panels(playing)?;
        self.out.activate_layout();
        Ok(())
    }

    /// A 2-D view. `bounds` are the visible ranges in the frame of `origin`: left to right and top to bottom (y down).
    pub(crate) fn spatial(
        &mut self,
        name: &str,
        origin: &str,
        contents: &[String],
        bounds: [[f64; 2]; 2],
    ) -> Result<Part, ViewerError> {
        let bounds = VisualBounds2D::new(Range2D {
            x_range: Range(bounds[0]),
            y_range: Range(bounds[1]),
        });
        self.view("2D", name, origin, contents, &[("VisualBounds2D", &bounds)])
    }

    /// Makes a view show all rows of an entity up to the cursor, instead of the newest row alone.
    pub(crate) fn show_past(&mut self, view: Part, entity: &str) -> Result<(), ViewerError> {
        let until_now = VisibleTimeRange {
            timeline: TIMELINE.into(),
            range: TimeRange {
                start: TimeRangeBoundary::Infinite,
                end: TimeRangeBoundary::CursorRelative(0.into()),
            },
        };
        let entity = ViewContents::blueprint_base_visualizer_path_for_entity(
            view.id,
            &EntityPath::from(entity),
        );
        self.out
            .layout(entity, &VisibleTimeRanges::new([until_now]))
    }

    /// A plot over time of the entities that `contents` name. `range` is that of the vertical axis; `None` means the
    /// range of the data.
    pub(crate) fn plot(
        &mut self,
        name: &str,
        contents: &[String],
        range: Option<Range1D>,
    ) -> Result<Part, ViewerError> {
        // All plots show the same range of time. The key is a view of its own, so that it does not cover lines.
        let time = TimeAxis::new().with_link(LinkAxis::LinkToGlobal);
        let legend = PlotLegend::new().with_visible(false);
        let mut axis = ScalarAxis::new();
        if let Some(range) = range {
            axis = axis.with_range(range);
        }
        self.view(
            "TimeSeries",
            name,
            "/",
            contents,
            &[
                ("TimeAxis", &time),
                ("PlotLegend", &legend),
                ("ScalarAxis", &axis),
            ],
        )
    }

    /// A list of text messages with their times.
    pub(crate) fn text_log(&mut self, name: &str, entity: &str) -> Result<Part, ViewerError> {
        let columns =
            [TextLogColumnKind::LogLevel, TextLogColumnKind::Body].map(|kind| TextLogColumn {
                visible: Bool(true),
                kind,
            });
        let columns = TextLogColumns::new().with_text_log_columns(columns);
        let contents = [format!("+ {entity}")];
        self.view(
            "TextLog",
            name,
            entity,
            &contents,
            &[("TextLogColumns", &columns)],
        )
    }

    /// A page of text.
    pub(crate) fn page(&mut self, name: &str, entity: &str) -> Result<Part, ViewerError> {
        self.view("TextDocument", name, entity, &[format!("+ {entity}")], &[])
    }

    /// Lanes of states over time.
    pub(crate) fn lanes(&mut self, name: &str, entity: &str) -> Result<Part, ViewerError> {
        let contents = [format!("+ {entity}/**")];
        self.view("StateTimeline", name, entity, &contents, &[])
    }

    /// A view of a class of the viewer.
    fn view(
        &mut self,
        class: &str,
        name: &str,
        origin: &str,
        contents: &[String],
        properties: &[Property<'_>],
    ) -> Result<Part, ViewerError> {
        let view = self.next("view");
        let path = view.path();
        let blueprint = ViewBlueprint::new(class)
            .with_display_name(name)
            .with_space_origin(origin);
        self.out.layout(path.as_str(), &blueprint)?;
        self.out.layout(
            format!("{path}/ViewContents"),
            &ViewContents::new(contents.iter().map(String::as_str)),
        )?;
        for (name, property) in properties {
            self.out.layout(format!("{path}/{name}"), *property)?;
        }
        Ok(view)
    }

    /// Tabs, of which one is visible at a time. The first is visible when the recording opens.
    pub(crate) fn tabs(&mut self, name: &str, parts: &[Part]) -> Result<Part, ViewerError> {
        let children: Vec<_> = parts.iter().map(|part| (*part, 1.0)).collect();
        self.container(ContainerKind::Tabs, name, &children)
    }

    /// A container of parts with their shares of its width or height. The first tab is the visible one.
    pub(crate) fn container(
        &mut self,
        kind: ContainerKind,
        name: &str,
        children: &[(Part, f32)],
    ) -> Result<Part, ViewerError> {
        let container = self.next("container");
        let shares = children.iter().map(|(_, share)| *share);
        let mut blueprint = ContainerBlueprint::new(kind)
            .with_display_name(name)
            .with_contents(children.iter().map(|(part, _)| part.path()));
        blueprint = match kind {
            ContainerKind::Horizontal => blueprint.with_col_shares(shares),
            ContainerKind::Vertical => blueprint.with_row_shares(shares),
            ContainerKind::Tabs | ContainerKind::Grid => match children.first() {
                Some((first, _)) => blueprint.with_active_tab(first.path().as_str()),
                None => blueprint,
            },
        };
        self.out.layout(container.path(), &blueprint)?;
        Ok(container)
    }

    /// Collapses the panels around the views, and sets the movement of the cursor.
    fn panels(&mut self, playing: Playing) -> Result<(), ViewerError> {
        for panel in ["blueprint_panel", "selection_panel"] {
            let collapsed = PanelBlueprint::new().with_state(PanelState::Collapsed);
            self.out.layout(panel, &collapsed)?;
        }
        // The collapsed panel still has the cursor and the buttons.
        let (play, repeat) = match playing {
            Playing::FromStart => (PlayState::Playing, LoopMode::All),
            Playing::AtTheEnd => (PlayState::Following, LoopMode::Off),
        };
        let time = TimePanelBlueprint::new()
            .with_state(PanelState::Collapsed)
            .with_timeline(TIMELINE)
            .with_play_state(play)
            .with_loop_mode(repeat);
        self.out.layout("time_panel", &time)
    }

    /// A new part. Its name follows from its number.
    fn next(&mut self, kind: &'static str) -> Part {
        self.parts += 1;
        Part {
            kind,
            id: Uuid::from_u128(self.parts),
        }
    }
}
