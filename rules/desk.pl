% Made from desk.model by `facetlog model compile`; not to be edited by hand.
% After a change of the model run `make models`.
:- module(desk, []).
:- use_module(facetlog(vocabulary)).
% desk.model:5
model(desk,
      "A table to work at: on panels or drawer blocks at both ends, with room for knees between them from one long side.",
      [top, left, right]).

% desk.model:5
specialises(desk, table).

% table.model:17  parts
candidate(desk, Thing, Parts) :-
    findall(Parts, likely(desk, Thing, Parts), Found),
    ( Found == [] -> distant(desk, Thing, Parts) ; member(Parts, Found) ).

% table.model:17  all that may satisfy its lines
likely(desk, Thing, [Top, Left, Right]) :-
    face_of(Thing, Top),
    possible(all([measured(Top), level(Top), upward(Top),
                  any([at_least(cover(Top), 0.75), at_least(share(Top), 0.8)]),
                  at_most(protrusion(Top), 0.4*elevation(Top)),
                  if_known(any([all([at_least(free_below(Top), 0.6),
                                     at_least(open_from_two_sides(Top), 0.3)]),
                                all([at_least(room_width(Top), 0.6*elevation(Top)),
                                     at_least(open_from_two_sides(Top), 0.1),
                                     between(level_length(Top), 1.2*elevation(Top),
                                             4*elevation(Top))])])),
                  at_least(level_width(Top), 0.35*elevation(Top)),
                  at_least(elevation(Top), 0.12*level_length(Top)),
                  if_known(at_most(see_through(Top), 0.8))])),
    face_of(Thing, Left),
    Left \== Top,
    possible(all([supports(Left, Top), at_least(width(Left), 0.5*width(Top))])),
    face_of(Thing, Right),
    Right \== Top,
    Right \== Left,
    possible(all([supports(Right, Top), at_least(width(Right), 0.5*width(Top)),
                  opposite(Left, Right), at_least(offset(Left, Right), 0.6*elevation(Top))])).

% table.model:17  near misses
distant(desk, Thing, [Top, Left, Right]) :-
    as_far_as_seen(Thing,
                   [step(Top, 6, all([measured(Top), level(Top), upward(Top)])),
                    step(Left, 3,
                         all([supports(Left, Top), at_least(width(Left), 0.5*width(Top))])),
                    step(Right, 3,
                         all([supports(Right, Top), at_least(width(Right), 0.5*width(Top))]))],
                   [Top, Left, Right]).

% table.model:18  closed closes top
means('desk.closed'(Closed, Top), closes(Closed, Top)).
% table.model:19  leg supports top
means('desk.leg'(Leg, Top), supports(Leg, Top)).

% table.model:18
members(desk, closed, _, [Top, Left, Right], Members) :-
    findall(Closed,
            ( shared_edge(Top, Closed, _), \+ memberchk(Closed, [Left, Right]),
              possible('desk.closed'(Closed, Top)) ), Found),
    sort(Found, Members).
% table.model:19
members(desk, leg, Thing, [Top, Left, Right], Members) :-
    findall(Leg,
            ( element_of(Thing, Leg), \+ memberchk(Leg, [Top, Left, Right]),
              possible('desk.leg'(Leg, Top)) ), Found),
    sort(Found, Members).

% desk.model:15  face left where left supports top, across(left)
condition(desk, left, "a panel or drawer block carries one end", _, [Top, Left, _],
          all([supports(Left, Top), soft(at_least(width(Left), 0.5*width(Top)), 0.1)])).
% desk.model:16  face right where right supports top, across(right)
condition(desk, right, "another carries the other end", _, [Top, _, Right],
          all([supports(Right, Top), soft(at_least(width(Right), 0.5*width(Top)), 0.1)])).
% table.model:21  top is measured, top is level, top is upward
condition(desk, level, "the top is level and faces up", _, [Top, _, _],
          all([measured(Top), level(Top), upward(Top)])).
% table.model:22  cover(top) at least 75 % or share(top) at least 80 %
condition(desk, cover, "the top covers the thing seen from above", _, [Top, _, _],
          any([soft(at_least(cover(Top), 0.75), 0.1), soft(at_least(share(Top), 0.8), 0.1)])).
% table.model:25  protrusion(top) at most 40 % of elevation(top)
condition(desk, topmost, "nothing rises above the top but what may stand on it", _, [Top, _, _],
          soft(at_most(protrusion(Top), 0.4*elevation(Top)), 0.1)).
% table.model:27  free_below(top) at least 60 % and open_from_two_sides(top) at least 30 % or for_knees(top)
condition(desk, beneath, "what is beneath it leaves room, and two sides open", _, [Top, _, _],
          if_known(any([all([soft(at_least(free_below(Top), 0.6), 0.1),
                             soft(at_least(open_from_two_sides(Top), 0.3), 0.1)]),
                        all([soft(at_least(room_width(Top), 0.6*elevation(Top)), 0.1),
                             soft(at_least(open_from_two_sides(Top), 0.1), 0.1),
                             soft(between(level_length(Top), 1.2*elevation(Top),
                                          4*elevation(Top)),
                                  0.1)])]))).
% table.model:29  free_below(top) at least 60 % and open_from_two_sides(top) at least 30 % or for_knees(top) or on_legs(top) and (each pair x, y of closed: not x adjoins y)
condition(desk, room, "there is free space beneath the top, or it stands on legs", Thing,
          [Top, Left, Right],
          any([all([soft(at_least(free_below(Top), 0.6), 0.1),
                    soft(at_least(open_from_two_sides(Top), 0.3), 0.1)]),
               all([soft(at_least(room_width(Top), 0.6*elevation(Top)), 0.1),
                    soft(at_least(open_from_two_sides(Top), 0.1), 0.1),
                    soft(between(level_length(Top), 1.2*elevation(Top), 4*elevation(Top)), 0.1)]),
               all([at_least_of(3, Leg, Leg_groups, 'desk.leg'(Leg, Top)),
                    any([soft(at_least(clear_below(Top), 0.5*elevation(Top)), 0.1),
                         some(G, Gs,
                              all([underside_of(G, Top),
                                   soft(at_least(clear_below(G), 0.5*elevation(Top)), 0.1)]))]),
                    each_pair(X, Y, Closed_members,
                              implies(all(['desk.closed'(X, Top), 'desk.closed'(Y, Top)]),
                                      not(adjoins(X, Y))))])])) :-
    members(desk, leg, Thing, [Top, Left, Right], Leg_members),
    separate(Leg_members, Leg_groups),
    findall(G, ( face_of(Thing, G), \+ memberchk(G, [Top, Left, Right]) ), Found),
    sort(Found, Gs),
    members(desk, closed, Thing, [Top, Left, Right], Closed_members).
% table.model:34  level_width(top) at least 35 % of elevation(top), elevation(top) at least 12 % of level_length(top)
condition(desk, proportion, "the top is no pole and no tray", _, [Top, _, _],
          all([soft(at_least(level_width(Top), 0.35*elevation(Top)), 0.1),
               soft(at_least(elevation(Top), 0.12*level_length(Top)), 0.1)])).
% table.model:36  elevation(top) between 30 cm and 120 cm
condition(desk, usual, "tables are 30 cm to 120 cm high", _, [Top, _, _],
          expect(0.25, if_known(soft(between(elevation(Top), metres(0.3), metres(1.2)), 0.1)))).
% desk.model:19  count(leg) at most 2 or there is a face end where end supports top, across(end)
condition(desk, ends, "it stands on two ends, not on legs", Thing, [Top, Left, Right],
          any([at_most_of(2, Leg, Leg_groups, 'desk.leg'(Leg, Top)),
               some(End, Ends,
                    all([supports(End, Top), soft(at_least(width(End), 0.5*width(Top)), 0.1)]))])) :-
    members(desk, leg, Thing, [Top, Left, Right], Leg_members),
    separate(Leg_members, Leg_groups),
    findall(End,
            ( face_of(Thing, End), \+ memberchk(End, [Top, Left, Right]),
              possible(all([supports(End, Top), at_least(width(End), 0.5*width(Top))])) ),
            Found),
    sort(Found, Ends).
% desk.model:21  left opposite right
condition(desk, facing, "the inner sides of the ends face each other", _, [_, Left, Right],
          opposite(Left, Right)).
% desk.model:23  offset(left, right) at least 60 % of elevation(top)
condition(desk, knees, "there is room for knees between the ends", _, [Top, Left, Right],
          soft(at_least(offset(Left, Right), 0.6*elevation(Top)), 0.1)).
% desk.model:25  there is a face panel_behind where panel_behind is upright, angle(panel_behind, left) = 90 deg ± 15 deg, between_ends(panel_behind), shuts(panel_behind)
condition(desk, rear, "a panel between the ends shuts one long side, at least in part", Thing,
          [Top, Left, Right],
          some(Panel_behind, Panel_behinds,
               all([upright(Panel_behind), soft(near(angle(Panel_behind, Left), 90, 15), 0.1),
                    soft(at_least(offset(Panel_behind, Left), 0*elevation(Top)), 0.1),
                    soft(at_least(offset(Panel_behind, Right), 0*elevation(Top)), 0.1),
                    soft(at_least(height(Panel_behind), 0.2*elevation(Top)), 0.1),
                    soft(at_least(length(Panel_behind), 0.5*offset(Left, Right)), 0.1)]))) :-
    findall(Panel_behind,
            ( face_of(Thing, Panel_behind), \+ memberchk(Panel_behind, [Top, Left, Right]),
              possible(all([upright(Panel_behind), near(angle(Panel_behind, Left), 90, 15),
                            at_least(offset(Panel_behind, Left), 0*elevation(Top)),
                            at_least(offset(Panel_behind, Right), 0*elevation(Top)),
                            at_least(height(Panel_behind), 0.2*elevation(Top)),
                            at_least(length(Panel_behind), 0.5*offset(Left, Right))])) ),
            Found),
    sort(Found, Panel_behinds).
% desk.model:29  see_through(top) at most 80 %
condition(desk, shut, "one does not see through beneath it", _, [Top, _, _],
          if_known(soft(at_most(see_through(Top), 0.8), 0.1))).
% desk.model:30  elevation(top) between 65 cm and 80 cm fading 5 cm
condition(desk, working_height, "desks are 65 cm to 80 cm high", _, [Top, _, _],
          expect(0.25,
                 if_known(fading(between(elevation(Top), metres(0.65), metres(0.8)),
                                 metres(0.05))))).

written(desk, left, 'desk.model:15', "face left where left supports top, across(left)").
written(desk, right, 'desk.model:16', "face right where right supports top, across(right)").
written(desk, level, 'table.model:21', "top is measured, top is level, top is upward").
written(desk, cover, 'table.model:22', "cover(top) at least 75 % or share(top) at least 80 %").
written(desk, topmost, 'table.model:25', "protrusion(top) at most 40 % of elevation(top)").
written(desk, beneath, 'table.model:27',
        "free_below(top) at least 60 % and open_from_two_sides(top) at least 30 % or for_knees(top)").
written(desk, room, 'table.model:29',
        "free_below(top) at least 60 % and open_from_two_sides(top) at least 30 % or for_knees(top) or on_legs(top) and (each pair x, y of closed: not x adjoins y)").
written(desk, proportion, 'table.model:34',
        "level_width(top) at least 35 % of elevation(top), elevation(top) at least 12 % of level_length(top)").
written(desk, usual, 'table.model:36', "elevation(top) between 30 cm and 120 cm").
written(desk, ends, 'desk.model:19',
        "count(leg) at most 2 or there is a face end where end supports top, across(end)").
written(desk, facing, 'desk.model:21', "left opposite right").
written(desk, knees, 'desk.model:23', "offset(left, right) at least 60 % of elevation(top)").
written(desk, rear, 'desk.model:25',
        "there is a face panel_behind where panel_behind is upright, angle(panel_behind, left) = 90 deg ± 15 deg, between_ends(panel_behind), shuts(panel_behind)").
written(desk, shut, 'desk.model:29', "see_through(top) at most 80 %").
written(desk, working_height, 'desk.model:30',
        "elevation(top) between 65 cm and 80 cm fading 5 cm").

% table.model:18
group(desk, Thing, [Top, Left, Right], closed, Members) :-
    members(desk, closed, Thing, [Top, Left, Right], Closed_members),
    findall(Closed, ( member(Closed, Closed_members), holds('desk.closed'(Closed, Top)) ),
            Members).
% table.model:19
group(desk, Thing, [Top, Left, Right], leg, Members) :-
    members(desk, leg, Thing, [Top, Left, Right], Leg_members),
    findall(Leg, ( member(Leg, Leg_members), holds('desk.leg'(Leg, Top)) ), Members).

% table.model:38
size(desk, _, [Top, _, _], length, length(Top)).
% table.model:39
size(desk, _, [Top, _, _], width, width(Top)).
% table.model:40
size(desk, _, [Top, _, _], height, elevation(Top)).
% desk.model:32
size(desk, _, [_, Left, Right], knee_space, offset(Left, Right)).
