% Supports that are one leg, against the plain definition: whatever is joined pair by pair.
:- use_module(library(plunit)).
:- use_module(library(random)).
:- use_module(library(lists)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog(grouping)).

% A thing of length 10, so that feet within 1.5 are one leg's; each support is a short edge.
standing(Points, Supports, Facts) :-
    findall(s(S)-P, nth1(S, Points, P), Numbered),
    findall(Name-P, ( member(s(S)-P, Numbered), atom_concat(e, S, Name) ), Named),
    findall(Name, member(Name-_, Named), Supports),
    findall(Fact,
            ( member(Name-[X, Y], Named),
              atom_concat(Name, a, V1),
              atom_concat(Name, b, V2),
              Z is 1.0,
              member(Fact, [ part_of(Name, t1), edge(Name, V1, V2), point(V1, X, Y, 0.0),
                             point(V2, X, Y, Z) ]) ),
            Facts).

groups(Points, Groups) :-
    standing(Points, Supports, Facts),
    gensym(test_scene, Scene),
    setup_call_cleanup(
        new_scene(Scene),
        ( forall(member(Fact, [thing(t1), up(0.0, 0.0, 1.0), thing_size(t1, 10.0, 5.0, 1.0)|Facts]),
                 assertz(Scene:Fact)),
          in_scene(Scene, separate(Supports, Groups)) ),
        destroy_scene(Scene)).

plain_groups(Points, Groups) :-
    findall(Name-P, ( nth1(S, Points, P), atom_concat(e, S, Name) ), Named),
    merge_all(Named, [], Groups0),
    findall(Names, ( member(G, Groups0), findall(N, member(N-_, G), Ns), sort(Ns, Names) ), Groups1),
    sort(Groups1, Groups).

merge_all([], Groups, Groups).
merge_all([Support|Supports], Groups0, Groups) :-
    partition([Group]>>near_group(Support, Group), Groups0, Near, Apart),
    append(Near, Members),
    merge_all(Supports, [[Support|Members]|Apart], Groups).

near_group(_-[X, Y], Group) :-
    member(_-[A, B], Group),
    sqrt((A - X)**2 + (B - Y)**2) =< 1.5,
    !.

% The faces of a gate: its front, round the way through, is of both posts; the posts are so near that
% their feet are within reach of each other, and their inner sides look at each other.
gate(Faces, Groups) :-
    gensym(test_scene, Scene),
    findall(Fact, gate_fact(Fact), Facts),
    setup_call_cleanup(
        new_scene(Scene),
        ( forall(member(Fact, [thing(t1), up(0.0, 0.0, 1.0), thing_size(t1, 10.0, 2.0, 0.2)|Facts]),
                 assertz(Scene:Fact)),
          in_scene(Scene, separate(Faces, Groups)) ),
        destroy_scene(Scene)).

gate_fact(Fact) :-
    outline(Face, Points),
    (   member(Fact, [part_of(Face, t1), on_ground(Face)])
    ;   nth1(I, Points, [X, Z]),
        format(atom(V), "~w~w", [Face, I]),
        member(Fact, [corner(Face, I, V), point(V, X, 0.0, Z)])
    ).
gate_fact(tilt(floor, 0.5, 0.5)).
gate_fact(Fact) :-
    side(Edge, Face, X),
    atom_concat(Edge, a, V1),
    atom_concat(Edge, b, V2),
    member(Fact, [ edge(Edge, V1, V2), point(V1, X, 0.0, 0.0), point(V2, X, 0.0, 8.0),
                   adjoins(front, Face, Edge), adjoins(Face, front, Edge) ]).
gate_fact(Fact) :-
    member(Fact, [ edge(high, h1, h2), point(h1, 8.0, 0.0, 8.0), point(h2, 8.0, 0.0, 10.0),
                   adjoins(armed, post, high), adjoins(post, armed, high) ]).
gate_fact(offset(A, B, Distance, 0.001)) :-
    side(_, A, XA),
    side(_, B, XB),
    A \== B,
    ( memberchk(B, [inner_a, outer_b]) -> Distance is XA - XB ; Distance is XB - XA ).

outline(front, [[0, 0], [0.2, 0], [0.2, 8], [1.4, 8], [1.4, 0], [1.6, 0], [1.6, 10], [0, 10]]).
outline(floor, [[0, 0], [1.6, 0.02], [1.6, 0], [0, 0.02]]).     % its corners as a picture has them
outline(whole, [[0, 0], [1.6, 0], [1.6, 10], [0, 10]]).
outline(armed, [[0, 0], [0.2, 0], [0.2, 8], [8.0, 8], [8.0, 10], [0, 10]]).   % a leg with an apron
outline(post, [[8.0, 0], [8.2, 0], [8.2, 10], [8.0, 10]]).                    % which ends at this leg
outline(backed, [[0, 0], [0.2, 0], [0.2, 4], [8.0, 4], [8.0, 0], [8.2, 0], [8.2, 20], [8.0, 20],
                 [8.0, 5], [0, 5]]).         % a chair's side: of two legs one rises to the back
outline(leg, [[0, 0], [0, 0], [0, 5], [0, 5]]).
outline(Face, [[X, 0], [X, 0], [X, 8], [X, 8]]) :-
    side(_, Face, X).

side(e1, outer_a, 0.0).
side(e2, inner_a, 0.2).
side(e3, inner_b, 1.4).
side(e4, outer_b, 1.6).

random_points(Seed, Points) :-
    set_random(seed(Seed)),
    findall([X, Y], ( between(1, 14, _), random(A), random(B), X is 10*A, Y is 5*B ), Points).

:- begin_tests(grouping).

test(nothing_is_no_group, Groups == []) :-
    groups([], Groups).
test(four_legs, N == 4) :-
    groups([[0.0, 0.0], [9.0, 0.0], [0.0, 4.0], [9.0, 4.0]], Groups),
    length(Groups, N).
test(a_row_of_near_feet_is_one, N == 1) :-
    findall([X, 0.0], ( between(0, 8, I), X is 1.4*I ), Points),
    groups(Points, Groups),
    length(Groups, N).
test(random_feet_group_as_pair_by_pair, [forall(between(1, 60, Seed)), Groups == Plain]) :-
    random_points(Seed, Points),
    groups(Points, Groups),
    plain_groups(Points, Plain).
test(two_posts_are_two, Groups == [[front, inner_a, outer_a], [front, inner_b, outer_b]]) :-
    gate([front, inner_a, inner_b, outer_a, outer_b], Found),
    maplist(msort, Found, Sorted),
    msort(Sorted, Groups).
test(a_front_alone_stands_on_both, Groups == [[front], [front]]) :-
    gate([front], Groups).
test(a_whole_face_is_one, Groups == [[whole]]) :-
    gate([whole], Groups).
test(what_lies_on_the_ground_is_one_however_uneven, Groups == [[floor]]) :-
    gate([floor], Groups).
test(sides_that_look_at_each_other_are_two_legs, Groups == [[inner_a], [inner_b]]) :-
    gate([inner_a, inner_b], Groups).
test(an_apron_joins_no_legs, Groups == [[armed], [post]]) :-
    gate([armed, post], Groups).
test(a_back_hides_no_leg, Groups == [[backed], [backed], [leg]]) :-
    gate([backed, leg], Groups).

:- end_tests(grouping).
