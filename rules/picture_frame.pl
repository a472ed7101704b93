% Made from picture_frame.model by `facetlog model compile`; not to be edited by hand.
% After a change of the model run `make models`.
:- module(picture_frame, []).
:- use_module(facetlog(vocabulary)).
% picture_frame.model:5
model(picture_frame, "A flat frame of four straight rails, open in the middle.", [front]).

% picture_frame.model:8  parts
candidate(picture_frame, Thing, Parts) :-
    findall(Parts, likely(picture_frame, Thing, Parts), Found),
    ( Found == [] -> distant(picture_frame, Thing, Parts) ; member(Parts, Found) ).

% picture_frame.model:8  all that may satisfy its lines
likely(picture_frame, Thing, [Front]) :-
    face_of(Thing, Front),
    possible(all([at_least(length(Front), 0.9*thing_length(Thing)),
                  at_least(width(Front), 0.9*thing_width(Thing)), near(corners(Front), 4, 0),
                  between(fill(Front), 0.08, 0.75)])).

% picture_frame.model:8  near misses
distant(picture_frame, Thing, [Front]) :-
    as_far_as_seen(Thing, [step(Front, 20, all([]))], [Front]).

% picture_frame.model:9  side adjoins front
means('picture_frame.side'(Side, Front), adjoins(Side, Front)).

% picture_frame.model:9
members(picture_frame, side, _, [Front], Members) :-
    findall(Side, ( shared_edge(Front, Side, _), possible('picture_frame.side'(Side, Front)) ),
            Found),
    sort(Found, Members).

% picture_frame.model:9  at least 5 faces side where side adjoins front
condition(picture_frame, side, "at least 5 faces side where side adjoins front", Thing, [Front],
          at_least_of(5, Side, Side_groups, 'picture_frame.side'(Side, Front))) :-
    members(picture_frame, side, Thing, [Front], Side_members),
    findall([Member], member(Member, Side_members), Side_groups).
% picture_frame.model:11  depth(this) at most 15 % of width(this)
condition(picture_frame, flat, "it is flat", Thing, [_],
          soft(at_most(depth(Thing), 0.15*thing_width(Thing)), 0.1)).
% picture_frame.model:12  length(front) at least 90 % of length(this), width(front) at least 90 % of width(this)
condition(picture_frame, large, "its front is its large side", Thing, [Front],
          all([soft(at_least(length(Front), 0.9*thing_length(Thing)), 0.1),
               soft(at_least(width(Front), 0.9*thing_width(Thing)), 0.1)])).
% picture_frame.model:14  corners(front) = 4
condition(picture_frame, straight, "the front has four straight sides", _, [Front],
          near(corners(Front), 4, 0)).
% picture_frame.model:15  fill(front) between 8 % and 75 %
condition(picture_frame, hollow, "the front is open in the middle", _, [Front],
          soft(between(fill(Front), 0.08, 0.75), 0.1)).
% picture_frame.model:16  length(this) between 8 cm and 200 cm
condition(picture_frame, hung, "it is no doorway", Thing, [_],
          if_known(soft(between(thing_length(Thing), metres(0.08), metres(2)), 0.1))).

written(picture_frame, side, 'picture_frame.model:9',
        "at least 5 faces side where side adjoins front").
written(picture_frame, flat, 'picture_frame.model:11', "depth(this) at most 15 % of width(this)").
written(picture_frame, large, 'picture_frame.model:12',
        "length(front) at least 90 % of length(this), width(front) at least 90 % of width(this)").
written(picture_frame, straight, 'picture_frame.model:14', "corners(front) = 4").
written(picture_frame, hollow, 'picture_frame.model:15', "fill(front) between 8 % and 75 %").
written(picture_frame, hung, 'picture_frame.model:16', "length(this) between 8 cm and 200 cm").

% picture_frame.model:9
group(picture_frame, Thing, [Front], side, Members) :-
    members(picture_frame, side, Thing, [Front], Side_members),
    findall(Side, ( member(Side, Side_members), holds('picture_frame.side'(Side, Front)) ),
            Members).

% picture_frame.model:18
size(picture_frame, _, [Front], length, length(Front)).
% picture_frame.model:19
size(picture_frame, _, [Front], width, width(Front)).
