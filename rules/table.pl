% Made from table.model by `facetlog model compile`; not to be edited by hand.
% After a change of the model run `make models`.
:- module(table, []).
:- use_module(facetlog(vocabulary)).
% table.model:4
model(table, "A level top with free space beneath it, on legs or panels that reach the ground.",
      [top]).

% table.model:17  parts
candidate(table, Thing, Parts) :-
    findall(Parts, likely(table, Thing, Parts), Found),
    ( Found == [] -> distant(table, Thing, Parts) ; member(Parts, Found) ).

% table.model:17  all that may satisfy its lines
likely(table, Thing, [Top]) :-
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
                  at_least(elevation(Top), 0.12*level_length(Top))])).

% table.model:17  near misses
distant(table, Thing, [Top]) :-
    as_far_as_seen(Thing, [step(Top, 20, all([measured(Top), level(Top), upward(Top)]))], [Top]).

% table.model:18  closed closes top
means('table.closed'(Closed, Top), closes(Closed, Top)).
% table.model:19  leg supports top
means('table.leg'(Leg, Top), supports(Leg, Top)).

% table.model:18
members(table, closed, _, [Top], Members) :-
    findall(Closed, ( shared_edge(Top, Closed, _), possible('table.closed'(Closed, Top)) ),
            Found),
    sort(Found, Members).
% table.model:19
members(table, leg, Thing, [Top], Members) :-
    findall(Leg,
            ( element_of(Thing, Leg), \+ memberchk(Leg, [Top]), possible('table.leg'(Leg, Top)) ),
            Found),
    sort(Found, Members).

% table.model:21  top is measured, top is level, top is upward
condition(table, level, "the top is level and faces up", _, [Top],
          all([measured(Top), level(Top), upward(Top)])).
% table.model:22  cover(top) at least 75 % or share(top) at least 80 %
condition(table, cover, "the top covers the thing seen from above", _, [Top],
          any([soft(at_least(cover(Top), 0.75), 0.1), soft(at_least(share(Top), 0.8), 0.1)])).
% table.model:25  protrusion(top) at most 40 % of elevation(top)
condition(table, topmost, "nothing rises above the top but what may stand on it", _, [Top],
          soft(at_most(protrusion(Top), 0.4*elevation(Top)), 0.1)).
% table.model:27  free_below(top) at least 60 % and open_from_two_sides(top) at least 30 % or for_knees(top)
condition(table, beneath, "what is beneath it leaves room, and two sides open", _, [Top],
          if_known(any([all([soft(at_least(free_below(Top), 0.6), 0.1),
                             soft(at_least(open_from_two_sides(Top), 0.3), 0.1)]),
                        all([soft(at_least(room_width(Top), 0.6*elevation(Top)), 0.1),
                             soft(at_least(open_from_two_sides(Top), 0.1), 0.1),
                             soft(between(level_length(Top), 1.2*elevation(Top),
                                          4*elevation(Top)),
                                  0.1)])]))).
% table.model:29  free_below(top) at least 60 % and open_from_two_sides(top) at least 30 % or for_knees(top) or on_legs(top) and (each pair x, y of closed: not x adjoins y)
condition(table, room, "there is free space beneath the top, or it stands on legs", Thing,
          [Top],
          any([all([soft(at_least(free_below(Top), 0.6), 0.1),
                    soft(at_least(open_from_two_sides(Top), 0.3), 0.1)]),
               all([soft(at_least(room_width(Top), 0.6*elevation(Top)), 0.1),
                    soft(at_least(open_from_two_sides(Top), 0.1), 0.1),
                    soft(between(level_length(Top), 1.2*elevation(Top), 4*elevation(Top)), 0.1)]),
               all([at_least_of(3, Leg, Leg_groups, 'table.leg'(Leg, Top)),
                    any([soft(at_least(clear_below(Top), 0.5*elevation(Top)), 0.1),
                         some(G, Gs,
                              all([underside_of(G, Top),
                                   soft(at_least(clear_below(G), 0.5*elevation(Top)), 0.1)]))]),
                    each_pair(X, Y, Closed_members,
                              implies(all(['table.closed'(X, Top), 'table.closed'(Y, Top)]),
                                      not(adjoins(X, Y))))])])) :-
    members(table, leg, Thing, [Top], Leg_members),
    separate(Leg_members, Leg_groups),
    findall(G, ( face_of(Thing, G), \+ memberchk(G, [Top]) ), Found),
    sort(Found, Gs),
    members(table, closed, Thing, [Top], Closed_members).
% table.model:34  level_width(top) at least 35 % of elevation(top), elevation(top) at least 12 % of level_length(top)
condition(table, proportion, "the top is no pole and no tray", _, [Top],
          all([soft(at_least(level_width(Top), 0.35*elevation(Top)), 0.1),
               soft(at_least(elevation(Top), 0.12*level_length(Top)), 0.1)])).
% table.model:36  elevation(top) between 30 cm and 120 cm
condition(table, usual, "tables are 30 cm to 120 cm high", _, [Top],
          expect(0.25, if_known(soft(between(elevation(Top), metres(0.3), metres(1.2)), 0.1)))).

written(table, level, 'table.model:21', "top is measured, top is level, top is upward").
written(table, cover, 'table.model:22', "cover(top) at least 75 % or share(top) at least 80 %").
written(table, topmost, 'table.model:25', "protrusion(top) at most 40 % of elevation(top)").
written(table, beneath, 'table.model:27',
        "free_below(top) at least 60 % and open_from_two_sides(top) at least 30 % or for_knees(top)").
written(table, room, 'table.model:29',
        "free_below(top) at least 60 % and open_from_two_sides(top) at least 30 % or for_knees(top) or on_legs(top) and (each pair x, y of closed: not x adjoins y)").
written(table, proportion, 'table.model:34',
        "level_width(top) at least 35 % of elevation(top), elevation(top) at least 12 % of level_length(top)").
written(table, usual, 'table.model:36', "elevation(top) between 30 cm and 120 cm").

% table.model:18
group(table, Thing, [Top], closed, Members) :-
    members(table, closed, Thing, [Top], Closed_members),
    findall(Closed, ( member(Closed, Closed_members), holds('table.closed'(Closed, Top)) ),
            Members).
% table.model:19
group(table, Thing, [Top], leg, Members) :-
    members(table, leg, Thing, [Top], Leg_members),
    findall(Leg, ( member(Leg, Leg_members), holds('table.leg'(Leg, Top)) ), Members).

% table.model:38
size(table, _, [Top], length, length(Top)).
% table.model:39
size(table, _, [Top], width, width(Top)).
% table.model:40
size(table, _, [Top], height, elevation(Top)).
